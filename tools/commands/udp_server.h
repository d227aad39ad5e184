#pragma once

/// @file
/// A server that answers datagrams, each to where it came from. The one place that knows of the
/// network (Boost.Asio for addresses, the system for datagrams). Tests: tests/tools/sitl_test.cc.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace lipoid {

class UdpServer {
 public:
  struct Reply {
    std::string_view bytes;  ///< empty: none
    bool last = false;       ///< the server ends after it
  };
  enum class Ended { kLast, kIdle, kStopped };

  /// Listens at an address ("127.0.0.1", "::1") and a port; 0 takes a free one. OptionError where
  /// it cannot.
  UdpServer(const std::string& address, std::uint16_t port);
  ~UdpServer();
  UdpServer(const UdpServer&) = delete;
  UdpServer& operator=(const UdpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// Whether only programs of this machine reach it.
  [[nodiscard]] bool is_loopback() const;

  /// Answers until a reply is the last, nothing came for so many seconds, or Stop() is called.
  Ended Run(const std::function<Reply(std::string_view datagram)>& answer,
            std::optional<double> idle_s);
  /// From any thread.
  void Stop();

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

}  // namespace lipoid
