#include "tools/commands/udp_server.h"

#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>

#include "tools/cli/listening.h"

namespace lipoid {

namespace asio = boost::asio;
using asio::ip::udp;
using Clock = std::chrono::steady_clock;

// How soon a server that hears nothing sees that it was stopped, or that it waited long enough.
constexpr timeval kLook{.tv_sec = 0, .tv_usec = 50'000};

struct UdpServer::Network {
  asio::io_context io;
  udp::socket socket{io};
  std::atomic<bool> stopped = false;
};

UdpServer::UdpServer(const std::string& address, std::uint16_t port)
    : network_(std::make_unique<Network>()) {
  cli::ListenAt<udp>(network_->socket,
                     address,
                     port,
                     [](udp::socket& socket, const udp::endpoint& endpoint, auto& error) {
                       socket.bind(endpoint, error);
                     });
}

UdpServer::~UdpServer() = default;

std::uint16_t UdpServer::port() const { return network_->socket.local_endpoint().port(); }

bool UdpServer::is_loopback() const {
  return network_->socket.local_endpoint().address().is_loopback();
}

// The datagram is waited for in the kernel, without Asio's reactor: one call to receive and one to
// answer, where lock step makes each of them a part of every frame.
UdpServer::Ended UdpServer::Run(const std::function<Reply(std::string_view)>& answer,
                                std::optional<double> idle_s) {
  const int socket = network_->socket.native_handle();
  (void)::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &kLook, sizeof kLook);
  std::array<char, 2048> buffer{};  // longer datagrams come cut, and have the wrong length then
  auto last_came = Clock::now();
  while (!network_->stopped) {
    udp::endpoint sender;
    auto size = static_cast<socklen_t>(sender.capacity());
    const ssize_t bytes = ::recvfrom(socket, buffer.data(), buffer.size(), 0, sender.data(), &size);
    if (bytes < 0) {
      // Nothing came; what else fails is about an earlier answer that nobody took.
      if (idle_s && Clock::now() - last_came > std::chrono::duration<double>(*idle_s))
        return Ended::kIdle;
      continue;
    }
    last_came = Clock::now();
    const Reply reply = answer({buffer.data(), static_cast<std::size_t>(bytes)});
    if (!reply.bytes.empty())  // an answer may be lost, as any datagram may be
      (void)::sendto(socket, reply.bytes.data(), reply.bytes.size(), 0, sender.data(), size);
    if (reply.last) return Ended::kLast;
  }
  return Ended::kStopped;
}

void UdpServer::Stop() { network_->stopped = true; }

}  // namespace lipoid
