#include <string>
#include <vector>

#include "tools/cli/run.h"
#include "tools/commands.h"

int main(int argc, char** argv) {
  lipoid::cli::KeepFreedMemory();
  lipoid::cli::CleanUpWhenEnded();
  return lipoid::cli::OnLargeStack([&] {
    return lipoid::cli::Run(lipoid::kCommands, std::vector<std::string>(argv + 1, argv + argc));
  });
}
