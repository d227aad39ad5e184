#pragma once

/// @file
/// A small HTTP/1.1 server over Boost.Beast, which parses and writes messages. What a client may take
/// is bounded: bytes of a header, seconds for a header and for each piece of a body that it sends or
/// reads, connections. Neither what it sends nor a file that it reads is ever held in memory by the
/// server: it is handed on piece by piece. Tests: tests/tools/serve/http_server_test.cc,
/// tests/tools/serve_test.py.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace lipoid {

/// The head of a request.
struct HttpRequest {
  std::string method;  ///< "GET"
  std::string path;    ///< "/a/b", as it came: nothing is decoded
  std::map<std::string, std::string, std::less<>> query;     ///< decoded
  std::vector<std::pair<std::string, std::string>> headers;  ///< names in lower case
  std::optional<std::uint64_t> body_bytes;                   ///< where the head states it

  /// The value of a header, named in lower case; nothing where it is not there.
  [[nodiscard]] std::optional<std::string_view> Header(std::string_view name) const;
  [[nodiscard]] std::size_t CountOf(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  std::string file;  ///< where not empty: a file whose bytes are the body
  std::vector<std::pair<std::string, std::string>> headers;
};

/// Thrown by whoever answers: a status and a sentence for the client.
class HttpError : public std::runtime_error {
 public:
  HttpError(int status, const std::string& message)
      : std::runtime_error(message), status_(status) {}
  [[nodiscard]] int status() const { return status_; }

 private:
  int status_;
};

/// Takes the body of one request. Destroyed without Finish() where the client went away.
class BodySink {
 public:
  virtual ~BodySink() = default;
  virtual void Write(std::string_view bytes) = 0;
  virtual HttpResponse Finish() = 0;
};

class HttpServer {
 public:
  struct Limits {
    std::size_t header_bytes = 16 << 10;
    std::size_t connections = 64;
    double idle_s = 20.0;    ///< from the last answer until the next header is there
    double body_s = 20.0;    ///< for each piece of a body
    double write_s = 120.0;  ///< for each piece of an answer
  };
  /// An answer at once, or who takes the body and answers then. May throw HttpError.
  using Answer = std::variant<HttpResponse, std::unique_ptr<BodySink>>;
  using Handler = std::function<Answer(const HttpRequest&)>;

  /// Listens at an address ("127.0.0.1", "::1") and a port; 0 takes a free one. OptionError where
  /// it cannot.
  HttpServer(const std::string& address, std::uint16_t port, const Limits& limits);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// Whether only programs of this machine reach it.
  [[nodiscard]] bool is_loopback() const;

  /// Answers until Stop(), by one thread: that of the caller.
  void Run(const Handler& handler);
  /// Run() until `look`, which is called every so many seconds by the same thread, says false.
  void Run(const Handler& handler, double every_s, const std::function<bool()>& look);
  /// From any thread.
  void Stop();

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

/// "%41" becomes "A"; nothing where it is not well-formed or holds a NUL.
[[nodiscard]] std::optional<std::string> PercentDecoded(std::string_view text);

}  // namespace lipoid
