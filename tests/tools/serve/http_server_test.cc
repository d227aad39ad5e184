#include "tools/serve/http_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/support/run_lipoid.h"

namespace lipoid {
namespace {

constexpr std::size_t kFileBytes = 16 << 20;

// Answers "/file" with a file of many bytes, "/nothing" with an error and all else with "answer".
class Served {
 public:
  explicit Served(double write_s) : server_("127.0.0.1", 0, {.write_s = write_s}) {
    std::ofstream(file_) << std::string(kFileBytes, 'x');
    thread_ = std::thread([this] {
      server_.Run([this](const HttpRequest& request) {
        if (request.path == "/nothing") throw HttpError(404, "nothing is here");
        HttpResponse response;
        response.body = "answer";
        if (request.path == "/file") response.file = file_;
        return response;
      });
    });
  }
  ~Served() {
    server_.Stop();
    thread_.join();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;
  [[nodiscard]] std::uint16_t port() const { return server_.port(); }

 private:
  std::string file_ = test::TestFolder() + "/file";
  HttpServer server_;
  std::thread thread_;
};

class Client {
 public:
  explicit Client(const Served& served) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    // The less waits on the way, the more the server depends on how fast this one reads.
    const int few_bytes = 64 << 10;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &few_bytes, sizeof few_bytes);
    const timeval patience{.tv_sec = 20, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(served.port());
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void Ask(const std::string& method, const std::string& path, bool last = false) {
    const std::string request = method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" +
                                (last ? "Connection: close\r\n" : "") + "\r\n";
    EXPECT_EQ(::send(socket_, request.data(), request.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(request.size()));
  }
  // All until the server closes, with a rest after each of so many bytes.
  [[nodiscard]] std::string Read(std::size_t bytes = 1 << 16,
                                 std::chrono::milliseconds rest = std::chrono::milliseconds(0)) {
    std::string text;
    std::string piece(bytes, '\0');
    while (true) {
      const ssize_t count = ::recv(socket_, piece.data(), piece.size(), MSG_WAITALL);
      if (count <= 0) return text;
      text.append(piece, 0, static_cast<std::size_t>(count));
      std::this_thread::sleep_for(rest);
    }
  }

 private:
  int socket_;
};

// The head and the body of an answer, which is the only one.
std::pair<std::string, std::string> Parts(const std::string& text) {
  const auto end = text.find("\r\n\r\n");
  if (end == std::string::npos) return {text, ""};
  return {text.substr(0, end + 4), text.substr(end + 4)};
}

TEST(HttpServer, GivesAllOfAFileToAClientThatIsSlow) {
  const Served served(1.0);
  Client client(served);
  client.Ask("GET", "/file", true);
  const auto began = std::chrono::steady_clock::now();
  const auto [head, body] = Parts(client.Read(512 << 10, std::chrono::milliseconds(100)));
  EXPECT_GT(std::chrono::steady_clock::now() - began, std::chrono::seconds(3));
  EXPECT_TRUE(head.starts_with("HTTP/1.1 200 OK\r\n")) << head;
  EXPECT_NE(head.find("Content-Length: 16777216\r\n"), std::string::npos) << head;
  EXPECT_EQ(body.size(), kFileBytes);
  EXPECT_EQ(body.find_first_not_of('x'), std::string::npos);
}

TEST(HttpServer, ClosesOnAClientThatReadsNothing) {
  const Served served(0.2);
  Client client(served);
  client.Ask("GET", "/file", true);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_LT(client.Read().size(), kFileBytes);
}

TEST(HttpServer, AnswersHeadByTheHeaderAlone) {
  const Served served(20.0);
  for (const std::string path : {"/", "/file", "/nothing"}) {
    Client alone(served);
    alone.Ask("GET", path, true);
    const std::string head = Parts(alone.Read()).first;
    // What is asked next on the same connection is answered next.
    Client client(served);
    client.Ask("HEAD", path);
    client.Ask("GET", "/", true);
    const auto [first, rest] = Parts(client.Read());
    const auto closing = head.find("Connection: close\r\n");
    ASSERT_NE(closing, std::string::npos) << head;
    EXPECT_EQ(first, std::string(head).erase(closing, 19)) << path;
    EXPECT_TRUE(rest.starts_with("HTTP/1.1 200 OK\r\n")) << path << rest.substr(0, 100);
    EXPECT_EQ(Parts(rest).second, "answer") << path;
  }
}

TEST(HttpServer, AnswersSeveralRequestsOfAConnection) {
  const Served served(20.0);
  Client client(served);
  client.Ask("GET", "/");
  client.Ask("GET", "/file");
  client.Ask("GET", "/nothing");
  client.Ask("GET", "/", true);
  std::string rest = client.Read();
  for (const std::size_t bytes : {std::size_t{6}, kFileBytes, std::size_t{16}, std::size_t{6}}) {
    const auto [head, body] = Parts(rest);
    EXPECT_NE(head.find("Content-Length: " + std::to_string(bytes) + "\r\n"), std::string::npos)
        << head.substr(0, 1000);
    ASSERT_GE(body.size(), bytes);
    rest = body.substr(bytes);
  }
  EXPECT_EQ(rest, "");
}

}  // namespace
}  // namespace lipoid
