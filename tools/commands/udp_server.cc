#include "tools/commands/udp_server.h"

#include <fmt/format.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "model/core/errors.h"

namespace lipoid {

namespace asio = boost::asio;
using asio::ip::udp;
using Clock = std::chrono::steady_clock;

struct UdpServer::Network {
  asio::io_context io;
  udp::socket socket{io};
  asio::steady_timer idle{io};
  udp::endpoint sender;
  std::array<char, 2048> buffer{};  // longer datagrams come cut, and have the wrong length then
  Clock::time_point last_came;
  std::function<Reply(std::string_view)> answer;
  Ended ended = Ended::kStopped;

  void Receive() {
    socket.async_receive_from(asio::buffer(buffer),
                              sender,
                              [this](const boost::system::error_code& error, std::size_t bytes) {
                                if (error == asio::error::operation_aborted) return;
                                // What else fails is about an earlier answer that nobody took
                                // (connection refused).
                                if (!error && Answered({buffer.data(), bytes})) return io.stop();
                                Receive();
                              });
  }

  bool Answered(std::string_view datagram) {
    last_came = Clock::now();
    const Reply reply = answer(datagram);
    if (!reply.bytes.empty()) {
      boost::system::error_code lost;  // as any datagram may be
      socket.send_to(asio::buffer(reply.bytes.data(), reply.bytes.size()), sender, 0, lost);
    }
    if (reply.last) ended = Ended::kLast;
    return reply.last;
  }

  void WatchIdle(Clock::duration limit) {
    idle.expires_at(last_came + limit);
    idle.async_wait([this, limit](const boost::system::error_code& error) {
      if (error) return;
      if (Clock::now() < last_came + limit) return WatchIdle(limit);
      ended = Ended::kIdle;
      io.stop();
    });
  }
};

UdpServer::UdpServer(const std::string& address, std::uint16_t port)
    : network_(std::make_unique<Network>()) {
  boost::system::error_code error;
  const auto host = asio::ip::make_address(address, error);
  if (error) {
    throw OptionError(fmt::format(
        "option --address: expected an address such as 127.0.0.1 or ::1, found '{}'", address));
  }
  udp::socket& socket = network_->socket;
  const udp::endpoint endpoint(host, port);
  socket.open(endpoint.protocol(), error);
  if (!error) socket.bind(endpoint, error);
  if (error) {
    throw OptionError(
        fmt::format("cannot listen at {} port {}: {}. Give another --port or --address",
                    address,
                    port,
                    error.message()));
  }
}

UdpServer::~UdpServer() = default;

std::uint16_t UdpServer::port() const { return network_->socket.local_endpoint().port(); }

bool UdpServer::is_loopback() const {
  return network_->socket.local_endpoint().address().is_loopback();
}

UdpServer::Ended UdpServer::Run(const std::function<Reply(std::string_view)>& answer,
                                std::optional<double> idle_s) {
  Network& n = *network_;
  n.answer = answer;
  n.ended = Ended::kStopped;
  n.last_came = Clock::now();
  n.Receive();
  if (idle_s) {
    n.WatchIdle(
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*idle_s)));
  }
  n.io.run();
  return n.ended;
}

void UdpServer::Stop() { network_->io.stop(); }

}  // namespace lipoid
