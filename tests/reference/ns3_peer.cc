// Runs ns-3's own RvBatteryModel on an exported ConfigStore text and prints its level.
//
//   ns3_peer CONFIG.txt MISSION.csv
//
// MISSION.csv has the columns time_s,current_A of the pack, discharge positive, each current over the
// interval that ends with its row. Prints one level a row. The test compiles it against Debian's
// libns3-dev where that is there; it is no part of the build.
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "ns3/config-store-module.h"
#include "ns3/core-module.h"
#include "ns3/node.h"
#include "ns3/rv-battery-model.h"
#include "ns3/simple-device-energy-model.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  ns3::Config::SetDefault("ns3::ConfigStore::Filename", ns3::StringValue(argv[1]));
  ns3::Config::SetDefault("ns3::ConfigStore::Mode", ns3::StringValue("Load"));
  ns3::Config::SetDefault("ns3::ConfigStore::FileFormat", ns3::StringValue("RawText"));
  ns3::ConfigStore store;
  store.ConfigureDefaults();

  std::vector<double> time_s;
  std::vector<double> current_A;
  std::ifstream csv(argv[2]);
  std::string line;
  std::getline(csv, line);
  while (std::getline(csv, line)) {
    time_s.push_back(std::stod(line));
    current_A.push_back(std::stod(line.substr(line.find(',') + 1)));
  }

  auto node = ns3::CreateObject<ns3::Node>();
  auto battery = ns3::CreateObject<ns3::RvBatteryModel>();
  auto device = ns3::CreateObject<ns3::SimpleDeviceEnergyModel>();
  // Samples are taken at the rows alone: the next periodic one is beyond the end.
  battery->SetSamplingInterval(ns3::Seconds(10.0 * (time_s.back() + 1.0)));
  battery->SetNode(node);
  device->SetEnergySource(battery);
  device->SetNode(node);
  battery->AppendDeviceEnergyModel(device);
  battery->Initialize();

  for (std::size_t k = 0; k < time_s.size(); ++k) {
    ns3::Simulator::Schedule(ns3::Seconds(time_s[k] - time_s.front()), [&, k] {
      // A sample takes the current of now for the interval that ends now.
      battery->UpdateEnergySource();
      std::printf("%.17g\n", battery->GetBatteryLevel());
      if (k + 1 < time_s.size() && current_A[k + 1] != current_A[k])
        device->SetCurrentA(current_A[k + 1]);
    });
  }
  device->SetCurrentA(current_A.size() > 1 ? current_A[1] : 0.0);
  ns3::Simulator::Stop(ns3::Seconds(time_s.back() - time_s.front() + 0.01));
  ns3::Simulator::Run();
  ns3::Simulator::Destroy();
}
