#include "tools/serve/guard.h"

#include <gtest/gtest.h>

#include <set>

namespace lipoid {
namespace {

HttpRequest Get(const std::string& host) {
  HttpRequest request;
  request.method = "GET";
  request.path = "/";
  request.headers = {{"host", host}};
  return request;
}

// The status with which a request is refused; 0 where it is not.
int Refused(const Guard& guard, const HttpRequest& request) {
  try {
    guard.Check(request);
    return 0;
  } catch (const HttpError& error) {
    return error.status();
  }
}

TEST(Guard, KeysAre32DigitsAndNeverTheSame) {
  std::set<std::string> keys;
  for (int k = 0; k < 1000; ++k) {
    const std::string key = RandomKey();
    EXPECT_EQ(key.size(), 32U);
    EXPECT_EQ(key.find_first_not_of("0123456789abcdef"), std::string::npos);
    keys.insert(key);
  }
  EXPECT_EQ(keys.size(), 1000U);
  const Guard guard({});
  EXPECT_NE(guard.key(), guard.report_key());
}

TEST(Guard, SecretsAreTheSameOrNot) {
  EXPECT_TRUE(SameSecret("", ""));
  EXPECT_TRUE(SameSecret("abc", "abc"));
  EXPECT_FALSE(SameSecret("abc", "abd"));
  EXPECT_FALSE(SameSecret("abc", "ab"));
  EXPECT_FALSE(SameSecret("", "a"));
}

TEST(Guard, FindsTheNameOfAHost) {
  EXPECT_EQ(HostName("localhost"), "localhost");
  EXPECT_EQ(HostName("LocalHost:80"), "localhost");
  EXPECT_EQ(HostName("[::1]:8080"), "::1");
  EXPECT_EQ(HostName("[::1]"), "::1");
  for (const char* const bad :
       {"", ":80", "a:", "a:x", "a:1:2", "a:1234567", "[::1", "[]", "[a]:1", "a:80@b", "[::1]80"}) {
    EXPECT_EQ(HostName(bad), "") << bad;
  }
}

TEST(Guard, ANameThatAnAttackerOwnsIsRefused) {
  const Guard guard({"Bench.Lab"});
  for (const char* const good : {"localhost:1", "127.0.0.1", "[::1]:9", "10.0.0.7:80", "bench.lab"})
    EXPECT_EQ(Refused(guard, Get(good)), 0) << good;
  for (const char* const bad :
       {"evil.example", "127.0.0.1.evil.example", "localhost.evil", "127.1"})
    EXPECT_EQ(Refused(guard, Get(bad)), 403) << bad;
  EXPECT_EQ(Refused(guard, Get("")), 400);
}

TEST(Guard, ARequestOfAnotherPageIsRefused) {
  const Guard guard({});
  HttpRequest request = Get("localhost:80");
  request.headers.emplace_back("origin", "http://localhost:80");
  request.headers.emplace_back("sec-fetch-site", "same-origin");
  EXPECT_EQ(Refused(guard, request), 0);
  request.headers[1].second = "http://localhost:81";
  EXPECT_EQ(Refused(guard, request), 403);
  request.headers[1].second = "http://localhost:80";
  request.headers[2].second = "cross-site";
  EXPECT_EQ(Refused(guard, request), 403);
  request.headers.emplace_back("sec-fetch-dest", "document");
  EXPECT_EQ(Refused(guard, request), 0);
  request.method = "POST";
  request.headers.emplace_back(Guard::kHeader, "1");
  EXPECT_EQ(Refused(guard, request), 403);
  request.headers[2].second = "same-origin";
  EXPECT_EQ(Refused(guard, request), 0);
  request.headers.pop_back();
  EXPECT_EQ(Refused(guard, request), 403);
}

}  // namespace
}  // namespace lipoid
