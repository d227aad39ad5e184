// lipoid serve: the same for a browser.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "identify/logs/draft.h"
#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "tools/cli/command_description.h"
#include "tools/cli/run.h"
#include "tools/commands.h"
#include "tools/report/report.h"
#include "tools/serve/guard.h"
#include "tools/serve/http_server.h"
#include "tools/serve/job_request.h"
#include "tools/serve/routes.h"
#include "tools/serve/session_folder.h"
#include "tools/serve/workbench.h"

namespace lipoid {
namespace {

constexpr std::uint64_t kBytesPerMegabyte = 1'000'000;

// Who is idle is looked for so often.
double LookEvery_s(double idle_s) { return std::min(1.0, 0.25 * idle_s); }

}  // namespace

cli::ExitCode ServeCommand(cli::CommandLine& line) {
  std::string address = "127.0.0.1";
  int port = 0;
  int jobs = 1;
  int max_file_MB = 1000;
  int max_total_MB = 4000;
  std::vector<std::string> names;
  std::optional<double> idle_s;
  line.Describe(
      "Shows lipoid in a browser: drop logs, see what each is, identify the cell, read the report, "
      "fly the result. Prints the address of the page, which holds the key to it, and serves until "
      "an interrupt (Ctrl-C). Files are kept in the folder of temporary files (TMPDIR) until then; "
      "nothing leaves this machine.",
      "lipoid serve");
  line.Example("lipoid serve --port 8080 --jobs 2");
  line.Option("port", port, Range{0, 65535}, "port to listen at; 0: any free one");
  line.Text("address", address, "ADDRESS", "address to listen at; 0.0.0.0 lets other machines in");
  line.Texts("allow-host",
             names,
             "NAME",
             "a name by which browsers reach this machine, beside localhost and its addresses");
  line.Option("jobs", jobs, Range{1, 64}, "how many jobs may run at once");
  line.Option("max-file-MB", max_file_MB, Range{1, 1'000'000}, "megabytes that a log may have");
  line.Option("max-total-MB",
              max_total_MB,
              Range{1, 1'000'000},
              "megabytes that all logs together may have");
  line.Option("idle-s",
              idle_s,
              Range{0.001, 1e6},
              "end when nobody asked anything for so many seconds and no job runs");
  if (!line.Parse()) return cli::ExitCode::kDone;
  RequireReport();

  const auto commands = cli::DescribeCommands(kCommands);
  const JobOptions options(commands);
  const int swept = SessionFolder::Sweep();
  if (swept > 0)
    line.Message("removed the files of {} earlier server{} that had no time to",
                 swept,
                 swept == 1 ? "" : "s");
  const SessionFolder folder;
  const WorkbenchLimits limits{.jobs = jobs,
                               .file_bytes = max_file_MB * kBytesPerMegabyte,
                               .total_bytes = max_total_MB * kBytesPerMegabyte};
  Workbench bench(folder.path(), "/proc/self/exe", limits, options);
  const Guard guard(names);
  const Routes routes(guard,
                      bench,
                      {{"version", Version()},
                       {"report_key", guard.report_key()},
                       {"file_bytes", limits.file_bytes},
                       {"total_bytes", limits.total_bytes},
                       {"files", limits.files},
                       {"jobs", limits.jobs},
                       {"no_logs", EndingsOfNoLogs()},
                       {"commands", options.ToJson()}});
  HttpServer server(address, static_cast<std::uint16_t>(port), {});
  std::atomic<bool> interrupted = false;
  const cli::StopRequest stop([&] {
    interrupted = true;
    server.Stop();
  });

  // Whoever starts it waits for this line, not for its end. To listen at all addresses is no address
  // to go to.
  const bool everywhere = address == "0.0.0.0" || address == "::";
  const std::string host = everywhere                               ? "localhost"
                           : address.find(':') != std::string::npos ? "[" + address + "]"
                                                                    : address;
  const std::string page = fmt::format("http://{}:{}/{}/\n", host, server.port(), guard.key());
  std::fputs(page.c_str(), stdout);
  std::fflush(stdout);
  line.Message("open this address in a browser; end with Ctrl-C");
  if (!server.is_loopback()) {
    line.Message(
        "other machines reach {} as well: who hears the network can read the address and use it. "
        "Safer is a tunnel to a server that listens at 127.0.0.1: ssh -L {}:127.0.0.1:{} USER@HOST",
        address,
        server.port(),
        server.port());
  }

  using Clock = std::chrono::steady_clock;
  auto last_asked = Clock::now();
  std::uint64_t requests = 0;
  const HttpServer::Handler handler = [&](const HttpRequest& request) {
    ++requests;
    last_asked = Clock::now();
    return routes(request);
  };
  if (idle_s) {
    server.Run(handler, LookEvery_s(*idle_s), [&] {
      if (bench.IsBusy()) last_asked = Clock::now();
      return std::chrono::duration<double>(Clock::now() - last_asked).count() < *idle_s;
    });
  } else {
    server.Run(handler);
  }
  line.summary() = {{"ended_by", interrupted.load() ? "interrupted" : "idle"},
                    {"requests", requests},
                    {"files", bench.files_taken()},
                    {"jobs", bench.jobs_taken()}};
  line.Message("ended; the files of the session are removed");
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
