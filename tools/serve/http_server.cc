#include "tools/serve/http_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/file.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <limits>

#include "model/core/text_cells.h"
#include "tools/cli/listening.h"

namespace lipoid {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::asio::ip::tcp;
using Error = boost::system::error_code;

constexpr std::size_t kPieceBytes = 256 << 10;
// A client that is refused is still sending: so much of it is read and forgotten, for it would not
// read the answer before.
constexpr std::size_t kForgottenBytes = 64 << 20;
constexpr double kForgetting_s = 2.0;

std::chrono::nanoseconds Seconds(double seconds) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// "a=1&b=2"; nothing where it is not well-formed or names something twice.
std::optional<std::map<std::string, std::string, std::less<>>> ParsedQuery(std::string_view text) {
  std::map<std::string, std::string, std::less<>> query;
  while (!text.empty()) {
    const auto end = std::min(text.find('&'), text.size());
    const std::string_view pair = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = std::min(pair.find('='), pair.size());
    auto name = PercentDecoded(pair.substr(0, equals));
    auto value = PercentDecoded(pair.substr(std::min(equals + 1, pair.size())));
    if (!name || !value || !query.emplace(std::move(*name), std::move(*value)).second) return {};
  }
  return query;
}

// An answer that is being written: its head, and then a text or a file piece by piece.
struct Outgoing {
  http::response<http::empty_body> head;
  std::string text;
  beast::file file;
  std::uint64_t left = 0;  // bytes of either
  bool keep_alive = false;
};

// One connection: header, body, answer, and again.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket,
             const HttpServer::Handler& handler,
             const HttpServer::Limits& limits,
             std::size_t& count)
      : stream_(std::move(socket)),
        buffer_(limits.header_bytes + kPieceBytes),
        handler_(handler),
        limits_(limits),
        count_(count) {
    ++count_;
  }
  ~Connection() { --count_; }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void ReadHeader() {
    sink_.reset();
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(limits_.header_bytes));
    parser_->body_limit(
        std::numeric_limits<std::uint64_t>::max());  // whoever takes the body counts
    stream_.expires_after(Seconds(limits_.idle_s));
    http::async_read_header(
        stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
          self->HeaderIsRead(error);
        });
  }

 private:
  void HeaderIsRead(Error error) {
    if (error == http::error::header_limit)
      return Refuse(431, "the header of the request is too long");
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return Refuse(400, fmt::format("this is no request of HTTP/1.1: {}", error.message()));
    if (error) return;  // it closed the connection, or took too long
    Guarded([&] {
      auto answer = handler_(Request());
      if (auto* response = std::get_if<HttpResponse>(&answer)) {
        Respond(std::move(*response), parser_->is_done() && parser_->keep_alive());
        return;
      }
      sink_ = std::move(std::get<std::unique_ptr<BodySink>>(answer));
      if (beast::iequals(parser_->get()[http::field::expect], "100-continue")) {
        Continue();
      } else {
        ReadPiece();
      }
    });
  }

  HttpRequest Request() const {
    const auto& message = parser_->get();
    HttpRequest request;
    request.method = std::string(message.method_string());
    const auto target = std::string_view(message.target().data(), message.target().size());
    const auto question = std::min(target.find('?'), target.size());
    request.path = target.substr(0, question);
    if (!request.path.starts_with('/')) throw HttpError(400, "the target is no path");
    auto query = ParsedQuery(target.substr(std::min(question + 1, target.size())));
    if (!query) throw HttpError(400, "the query of the address is not well-formed");
    request.query = std::move(*query);
    for (const auto& field : message) {
      request.headers.emplace_back(
          LowerCase({field.name_string().data(), field.name_string().size()}),
          std::string(field.value()));
    }
    if (const auto length = parser_->content_length()) request.body_bytes = *length;
    return request;
  }

  void Continue() {
    auto response = std::make_shared<http::response<http::empty_body>>(http::status::continue_, 11);
    stream_.expires_after(Seconds(limits_.body_s));
    http::async_write(
        stream_, *response, [self = shared_from_this(), response](Error error, std::size_t) {
          if (!error) self->Guarded([&] { self->ReadPiece(); });
        });
  }

  void ReadPiece() {
    if (parser_->is_done()) return Respond(sink_->Finish(), parser_->keep_alive());
    piece_.resize(kPieceBytes);
    parser_->get().body().data = piece_.data();
    parser_->get().body().size = piece_.size();
    stream_.expires_after(Seconds(limits_.body_s));
    http::async_read(
        stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
          if (error && error != http::error::need_buffer) {
            self->sink_.reset();  // the client went away, or took too long
            return;
          }
          self->Guarded([&] {
            self->sink_->Write(
                {self->piece_.data(), self->piece_.size() - self->parser_->get().body().size});
            self->ReadPiece();
          });
        });
  }

  template <class Function>
  void Guarded(Function&& function) {
    try {
      function();
    } catch (const HttpError& error) {
      Refuse(error.status(), error.what());
    } catch (const std::exception& error) {
      Refuse(500,
             fmt::format("this should not have happened, and is a mistake of lipoid: {}",
                         error.what()));
    }
  }

  void Refuse(int status, const std::string& message) {
    sink_.reset();
    HttpResponse response;
    response.status = status;
    response.body = message + "\n";
    Respond(std::move(response), parser_->is_done() && parser_->keep_alive());
  }

  void Respond(HttpResponse&& response, bool keep_alive) {
    Outgoing& out = outgoing_.emplace();
    out.keep_alive = keep_alive;
    if (response.file.empty()) {
      out.text = std::move(response.body);
      out.left = out.text.size();
    } else {
      Error error;
      out.file.open(response.file.c_str(), beast::file_mode::scan, error);
      if (!error) out.left = out.file.size(error);
      if (error) throw HttpError(404, "this file is not there any more");
    }
    auto& head = out.head;
    head.version(11);
    head.result(static_cast<unsigned>(response.status));
    head.set(http::field::content_type, response.type);
    // Whatever is answered: it is not kept, not sniffed, not embedded elsewhere and tells nobody
    // where it came from.
    head.set(http::field::cache_control, "no-store");
    head.set("X-Content-Type-Options", "nosniff");
    head.set("Referrer-Policy", "no-referrer");
    head.set("Cross-Origin-Opener-Policy", "same-origin");
    head.set("Cross-Origin-Resource-Policy", "same-origin");
    if (response.type.starts_with("text/plain"))
      head.set("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
    for (const auto& [name, value] : response.headers) head.set(name, value);
    head.keep_alive(keep_alive);
    head.content_length(out.left);
    // A client that asks for the head takes whatever follows it for the next answer.
    if (parser_->get().method() == http::verb::head) out.left = 0;
    stream_.expires_after(Seconds(limits_.write_s));
    http::async_write(stream_, head, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) self->WritePiece();
    });
  }

  // Each piece has a time of its own: how long all of a file takes is for the network to say.
  void WritePiece() {
    Outgoing& out = *outgoing_;
    if (out.left == 0) return Answered();
    const auto bytes = static_cast<std::size_t>(std::min<std::uint64_t>(out.left, kPieceBytes));
    asio::const_buffer piece;
    if (out.file.is_open()) {
      piece_.resize(bytes);
      Error error;
      // Where a file became shorter than was said, closing is all that tells the client.
      if (out.file.read(piece_.data(), bytes, error) != bytes || error) return;
      piece = asio::const_buffer(piece_.data(), bytes);
    } else {
      piece = asio::const_buffer(out.text.data() + (out.text.size() - out.left), bytes);
    }
    out.left -= bytes;
    stream_.expires_after(Seconds(limits_.write_s));
    asio::async_write(stream_, piece, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) self->WritePiece();
    });
  }

  void Answered() {
    const bool keep_alive = outgoing_->keep_alive;
    outgoing_.reset();
    if (keep_alive) {
      ReadHeader();
    } else {
      Close();
    }
  }

  void Close() {
    Error ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(Seconds(kForgetting_s));
    Forget();
  }

  void Forget() {
    piece_.resize(kPieceBytes);
    stream_.async_read_some(asio::buffer(piece_),
                            [self = shared_from_this()](Error error, std::size_t bytes) {
                              self->forgotten_bytes_ += bytes;
                              if (!error && self->forgotten_bytes_ < kForgottenBytes)
                                self->Forget();
                            });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::buffer_body>> parser_;
  std::unique_ptr<BodySink> sink_;
  std::optional<Outgoing> outgoing_;
  std::string piece_;
  std::size_t forgotten_bytes_ = 0;
  const HttpServer::Handler& handler_;
  const HttpServer::Limits& limits_;
  std::size_t& count_;
};

}  // namespace

struct HttpServer::Network {
  Limits limits;
  Handler handler;
  std::size_t connections =
      0;  // after the context in no order: it is counted down by what that holds
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::steady_timer again{io};
  asio::steady_timer look{io};

  void Accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) {  // no descriptor is free, for example: some come back
        again.expires_after(std::chrono::milliseconds(100));
        again.async_wait([this](Error stopped) {
          if (!stopped) Accept();
        });
        return;
      }
      // One too many is closed at once.
      if (connections < limits.connections) {
        Error ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        std::make_shared<Connection>(std::move(socket), handler, limits, connections)->ReadHeader();
      }
      Accept();
    });
  }

  void Look(double every_s, const std::function<bool()>& goes_on) {
    look.expires_after(Seconds(every_s));
    look.async_wait([this, every_s, &goes_on](Error stopped) {
      if (stopped) return;
      if (!goes_on()) return io.stop();
      Look(every_s, goes_on);
    });
  }
};

HttpServer::HttpServer(const std::string& address, std::uint16_t port, const Limits& limits)
    : network_(std::make_unique<Network>()) {
  network_->limits = limits;
  const auto listen = [](tcp::acceptor& acceptor, const tcp::endpoint& endpoint, Error& error) {
    acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  };
  cli::ListenAt<tcp>(network_->acceptor, address, port, listen);
}

HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const { return network_->acceptor.local_endpoint().port(); }

bool HttpServer::is_loopback() const {
  return network_->acceptor.local_endpoint().address().is_loopback();
}

void HttpServer::Run(const Handler& handler) {
  network_->handler = handler;
  network_->Accept();
  network_->io.run();
}

void HttpServer::Run(const Handler& handler, double every_s, const std::function<bool()>& look) {
  network_->Look(every_s, look);
  Run(handler);
}

void HttpServer::Stop() { network_->io.stop(); }

std::optional<std::string_view> HttpRequest::Header(std::string_view name) const {
  for (const auto& [key, value] : headers) {
    if (key == name) return value;
  }
  return std::nullopt;
}

std::size_t HttpRequest::CountOf(std::string_view name) const {
  return static_cast<std::size_t>(std::count_if(
      headers.begin(), headers.end(), [&](const auto& field) { return field.first == name; }));
}

std::optional<std::string> PercentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] != '%') {
      decoded += text[k];
      continue;
    }
    if (k + 2 >= text.size()) return std::nullopt;
    const int high = HexDigit(text[k + 1]);
    const int low = HexDigit(text[k + 2]);
    if (high < 0 || low < 0 || high + low == 0) return std::nullopt;
    decoded += static_cast<char>(16 * high + low);
    k += 2;
  }
  return decoded;
}

}  // namespace lipoid
