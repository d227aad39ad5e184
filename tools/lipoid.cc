#include <fcntl.h>

#include <cerrno>
#include <string>
#include <vector>

#include "tools/cli/run.h"
#include "tools/commands.h"

namespace {

// A file that is opened while a standard stream is closed would take its number, and messages would be written
// into it.
void OccupyStandardStreams() {
  for (int stream = 0; stream <= 2; ++stream) {
    if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF) (void)::open("/dev/null", O_RDWR);
  }
}

}  // namespace

int main(int argc, char** argv) {
  OccupyStandardStreams();
  lipoid::cli::KeepFreedMemory();
  lipoid::cli::CleanUpWhenEnded();
  return lipoid::cli::OnLargeStack([&] {
    return lipoid::cli::Run(lipoid::kCommands, std::vector<std::string>(argv + 1, argv + argc));
  });
}
