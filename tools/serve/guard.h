#pragma once

/// @file
/// Who may talk to the server. A page of another site that the same browser shows can send requests to
/// 127.0.0.1, and by DNS rebinding it can even make its own name lead there. Therefore
///
///   - the first part of every path is a random key, which only who saw the address knows;
///   - the Host is an address in numbers, "localhost", or a name that was allowed: a name that an
///     attacker owns is none of them;
///   - what the browser says of where a request comes from (Origin, Sec-Fetch-Site) is this server;
///   - a request that changes something has a header that no form can send.
///
/// Tests: tests/tools/serve/guard_test.cc, tests/tools/serve_test.py.

#include <string>
#include <string_view>
#include <vector>

#include "tools/serve/http_server.h"

namespace lipoid {

/// 32 hexadecimal digits from the random generator of OpenSSL.
[[nodiscard]] std::string RandomKey();

/// Whether both are the same, in a time that says nothing of where they differ.
[[nodiscard]] bool SameSecret(std::string_view a, std::string_view b);

/// The name of a Host header without its port: "[::1]:80" is "::1"; "" where it is not well-formed.
[[nodiscard]] std::string HostName(std::string_view host);

class Guard {
 public:
  /// The header that a request must have which changes something.
  static constexpr std::string_view kHeader = "x-lipoid";

  /// Names that lead here beside localhost and addresses in numbers.
  explicit Guard(std::vector<std::string> names);

  /// The key of the page and of all that it asks.
  [[nodiscard]] const std::string& key() const { return key_; }
  /// The key of finished reports alone: a report is a page of its own, and knows its address.
  [[nodiscard]] const std::string& report_key() const { return report_key_; }

  /// HttpError unless the request came from a page of this server, or from no page.
  void Check(const HttpRequest& request) const;

 private:
  std::vector<std::string> names_;
  std::string key_ = RandomKey();
  std::string report_key_ = RandomKey();
};

}  // namespace lipoid
