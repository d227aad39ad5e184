#include "tools/serve/routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tools/report/web_asset.h"

namespace lipoid {
namespace {

constexpr std::size_t kMostBytesOfJson = 1 << 20;

// The page loads its own script and style and talks to this server, and that is all; nobody frames it.
constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
// A report brings its own policy; here it is cut off from this server, whose pages alone show it.
constexpr const char* kReportPolicy =
    "sandbox allow-scripts allow-downloads; frame-ancestors 'self'";

[[noreturn]] void NotFound() { throw HttpError(404, "there is nothing at this address"); }

HttpResponse JsonResponse(const Json& json, int status = 200) {
  HttpResponse response;
  response.status = status;
  response.type = "application/json";
  // A name may hold bytes that are no UTF-8.
  response.body = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  return response;
}

// A body of JSON, held in memory.
class JsonSink : public BodySink {
 public:
  explicit JsonSink(std::function<HttpResponse(const Json&)> answer) : answer_(std::move(answer)) {}

  void Write(std::string_view bytes) override {
    text_ += bytes;
    if (text_.size() > kMostBytesOfJson) throw HttpError(413, "the request is too long");
  }
  HttpResponse Finish() override {
    return answer_(text_.empty() ? Json::object() : ParsedBody(text_));
  }

 private:
  std::function<HttpResponse(const Json&)> answer_;
  std::string text_;
};

HttpServer::Answer TakesJson(const HttpRequest& request,
                             std::function<HttpResponse(const Json&)> answer) {
  if (request.body_bytes.value_or(0) > kMostBytesOfJson)
    throw HttpError(413, "the request is too long");
  return std::make_unique<JsonSink>(std::move(answer));
}

void OnlyMethod(const HttpRequest& request, std::string_view method) {
  if (request.method == method) return;
  throw HttpError(405, fmt::format("this address takes {} alone", method));
}

// "files/3/cancel" with "files/" and "/cancel" is 3.
std::optional<int> Numbered(std::string_view text,
                            std::string_view before,
                            std::string_view after) {
  if (text.size() <= before.size() + after.size() || !text.starts_with(before) ||
      !text.ends_with(after))
    return std::nullopt;
  text.remove_prefix(before.size());
  text.remove_suffix(after.size());
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc{} && end == text.data() + text.size() && number > 0;
  return whole ? std::optional(number) : std::nullopt;
}

std::string TypeOf(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".json")) return "application/json";
  if (name.ends_with(".csv")) return "text/csv; charset=utf-8";
  return "text/plain; charset=utf-8";
}

HttpResponse Asset(std::string_view name, const char* type) {
  const auto* const text = FindWebAsset(name);
  if (text == nullptr) NotFound();
  HttpResponse response;
  response.type = type;
  response.body = *text;
  response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
  return response;
}

}  // namespace

Routes::Routes(const Guard& guard, Workbench& bench, Json program)
    : guard_(guard), bench_(bench), program_(std::move(program)) {}

HttpServer::Answer Routes::operator()(const HttpRequest& request) const {
  guard_.Check(request);
  const std::string_view path = request.path;
  const auto end = std::min(path.find('/', 1), path.size());
  const std::string_view key = path.substr(1, end - 1);
  const bool whole = SameSecret(key, guard_.key());
  const bool report = SameSecret(key, guard_.report_key());
  if (!whole && !report) {
    throw HttpError(
        403,
        "the key of this session is missing or wrong; use the address that lipoid serve "
        "printed when it was started");
  }
  const std::string_view rest = path.substr(std::min(end + 1, path.size()));
  if (report) {
    OnlyMethod(request, "GET");
    return OutputOf(rest, true);
  }
  if (rest.starts_with("api/")) return Api(request, rest.substr(4));
  OnlyMethod(request, "GET");
  if (end == path.size()) {  // relative addresses of the page need the stroke at the end
    HttpResponse response;
    response.status = 308;
    response.headers.emplace_back("Location", fmt::format("/{}/", guard_.key()));
    return response;
  }
  if (rest.empty()) return Asset("serve.html", "text/html; charset=utf-8");
  if (rest == "serve.js") return Asset(rest, "text/javascript; charset=utf-8");
  if (rest == "serve.css") return Asset(rest, "text/css; charset=utf-8");
  if (rest == "campaign.toml") {
    HttpResponse response;
    response.body = bench_.CampaignText();
    response.headers.emplace_back("Content-Disposition", "attachment; filename=\"campaign.toml\"");
    return response;
  }
  return OutputOf(rest, false);
}

HttpServer::Answer Routes::Api(const HttpRequest& request, std::string_view rest) const {
  if (rest == "program") {
    OnlyMethod(request, "GET");
    return JsonResponse(program_);
  }
  if (rest == "state") {
    OnlyMethod(request, "GET");
    const std::string version = fmt::format("\"{}\"", bench_.version());
    HttpResponse response;
    if (request.Header("if-none-match") == version) {
      response.status = 304;
    } else {
      const Json state = bench_.State();
      response = JsonResponse(state);
      response.headers.emplace_back(
          "ETag", fmt::format("\"{}\"", state.at("version").get<std::uint64_t>()));
    }
    return response;
  }
  if (rest == "files") {
    OnlyMethod(request, "POST");
    const auto name = request.query.find("name");
    if (name == request.query.end()) throw HttpError(400, "a file needs a name: files?name=...");
    return bench_.Upload(name->second, request.body_bytes);
  }
  if (const auto id = Numbered(rest, "files/", "")) {
    OnlyMethod(request, "DELETE");
    bench_.RemoveFile(*id);
    return JsonResponse(Json::object());
  }
  if (rest == "change") {
    OnlyMethod(request, "POST");
    return TakesJson(request, [this](const Json& change) {
      bench_.Change(change);
      return JsonResponse(Json::object());
    });
  }
  if (rest == "jobs") {
    OnlyMethod(request, "POST");
    return TakesJson(request, [this](const Json& asked) {
      return JsonResponse({{"id", bench_.Start(asked)}}, 201);
    });
  }
  if (const auto id = Numbered(rest, "jobs/", "/cancel")) {
    OnlyMethod(request, "POST");
    return TakesJson(request, [this, id = *id](const Json&) {
      bench_.CancelJob(id);
      return JsonResponse(Json::object());
    });
  }
  if (const auto id = Numbered(rest, "jobs/", "")) {
    OnlyMethod(request, "DELETE");
    bench_.RemoveJob(*id);
    return JsonResponse(Json::object());
  }
  NotFound();
}

HttpResponse Routes::OutputOf(std::string_view rest, bool to_look_at) const {
  const auto stroke = rest.rfind('/');
  if (stroke == rest.npos) NotFound();
  const std::string_view name = rest.substr(stroke + 1);
  const auto id = Numbered(rest.substr(0, stroke), "jobs/", "");
  if (!id || (to_look_at && name != "report.html")) NotFound();
  HttpResponse response;
  response.file = bench_.Output(*id, name);  // one of the names that a job may write
  response.type = TypeOf(name);
  if (to_look_at) {
    response.headers.emplace_back("Content-Security-Policy", kReportPolicy);
  } else {
    const auto dot = name.rfind('.');
    response.headers.emplace_back(
        "Content-Disposition",
        fmt::format(
            "attachment; filename=\"{}-{}{}\"", name.substr(0, dot), *id, name.substr(dot)));
    response.headers.emplace_back("Content-Security-Policy", "sandbox; default-src 'none'");
  }
  return response;
}

}  // namespace lipoid
