#include "tools/serve/guard.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <optional>

#include "model/core/text_cells.h"

namespace lipoid {

std::string RandomKey() {
  unsigned char bytes[16];
  if (RAND_bytes(bytes, sizeof bytes) != 1)
    throw std::runtime_error("the random generator of OpenSSL gave nothing");
  std::string key;
  for (const unsigned char byte : bytes) key += fmt::format("{:02x}", byte);
  return key;
}

bool SameSecret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string HostName(std::string_view host) {
  std::string_view name = host;
  std::string_view port;
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    if (end == host.npos) return "";
    name = host.substr(1, end - 1);
    port = host.substr(end + 1);
    if (name.find(':') == name.npos) return "";
  } else if (const auto colon = host.find(':'); colon != host.npos) {
    name = host.substr(0, colon);
    port = host.substr(colon);
  }
  const bool digits = port.empty() || (port.size() > 1 && port.size() < 7 && port[0] == ':' &&
                                       port.find_first_not_of("0123456789", 1) == port.npos);
  return digits ? LowerCase(std::string(name)) : "";
}

Guard::Guard(std::vector<std::string> names) : names_(std::move(names)) {
  for (std::string& name : names_) name = LowerCase(std::move(name));
  names_.emplace_back("localhost");
}

void Guard::Check(const HttpRequest& request) const {
  const auto host = request.Header("host");
  const std::string name = host ? HostName(*host) : "";
  if (name.empty() || request.CountOf("host") != 1)
    throw HttpError(400, "a request names the host that it is for, once");
  boost::system::error_code no_address;
  boost::asio::ip::make_address(name, no_address);
  if (no_address && std::find(names_.begin(), names_.end(), name) == names_.end()) {
    throw HttpError(403,
                    "this server does not go by that name; use the address that lipoid serve "
                    "printed, or start it with --allow-host NAME");
  }
  const bool reads = request.method == "GET";
  if (const auto origin = request.Header("origin");
      origin && *origin != fmt::format("http://{}", *host)) {
    throw HttpError(403, "this request comes from the page of another site");
  }
  // A link from elsewhere may be followed, for the key is in the address; but no page of another site
  // may load anything from here.
  const auto site = request.Header("sec-fetch-site");
  const bool followed = reads && request.Header("sec-fetch-dest") == "document";
  if (site && *site != "same-origin" && *site != "none" && !followed)
    throw HttpError(403, "this request comes from the page of another site");
  if (!reads && !request.Header(kHeader)) {
    throw HttpError(403,
                    fmt::format("a request that changes something has the header {}", kHeader));
  }
}

}  // namespace lipoid
