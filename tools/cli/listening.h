#pragma once

/// @file
/// Where a server listens: --address and --port, for any protocol of Asio. For sources that include
/// Asio already; others take the classes of the servers. Tests: tests/tools/serve_test.py,
/// tests/tools/sitl_test.py.

#include <fmt/format.h>

#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <string>

#include "model/core/errors.h"

namespace lipoid::cli {

/// Opens `socket`, and binds it to `address` and `port` by `bind(socket, endpoint, error)`, which does
/// what else the protocol needs. OptionError where the address is none, or nobody may listen there.
template <class Protocol, class Socket, class Bind>
void ListenAt(Socket& socket, const std::string& address, std::uint16_t port, Bind&& bind) {
  boost::system::error_code error;
  const auto host = boost::asio::ip::make_address(address, error);
  if (error) {
    throw OptionError(fmt::format(
        "option --address: expected an address such as 127.0.0.1 or ::1, found '{}'", address));
  }
  const typename Protocol::endpoint endpoint(host, port);
  socket.open(endpoint.protocol(), error);
  if (!error) bind(socket, endpoint, error);
  if (error) {
    throw OptionError(
        fmt::format("cannot listen at {} port {}: {}. Give another --port or --address",
                    address,
                    port,
                    error.message()));
  }
}

}  // namespace lipoid::cli
