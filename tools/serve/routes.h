#pragma once

/// @file
/// Which address does what. All of them begin with the key of the session (guard.h):
///
///   GET    /KEY/                      the page; serve.js and serve.css beside it
///   GET    /KEY/api/program           what lipoid offers: options, names, limits
///   GET    /KEY/api/state             the workbench; 304 where its version (ETag) is known
///   POST   /KEY/api/files?name=...    a log, its bytes as they are
///   DELETE /KEY/api/files/3
///   POST   /KEY/api/change            what a person changed (Workbench::Change)
///   POST   /KEY/api/jobs              what is to be run (JobOptions::Read)
///   POST   /KEY/api/jobs/3/cancel
///   DELETE /KEY/api/jobs/3
///   GET    /KEY/campaign.toml         the campaign as it is now
///   GET    /KEY/jobs/3/cell.json      what a job wrote, to be kept
///   GET    /REPORT-KEY/jobs/3/report.html   the report of a job, to be looked at
///
/// Tests: tests/tools/serve_test.py.

#include <nlohmann/json.hpp>

#include "model/core/json.h"
#include "tools/serve/guard.h"
#include "tools/serve/http_server.h"
#include "tools/serve/workbench.h"

namespace lipoid {

class Routes {
 public:
  /// `program` is what /api/program answers. All of them are kept by the caller.
  Routes(const Guard& guard, Workbench& bench, Json program);

  [[nodiscard]] HttpServer::Answer operator()(const HttpRequest& request) const;

 private:
  [[nodiscard]] HttpServer::Answer Api(const HttpRequest& request, std::string_view rest) const;
  [[nodiscard]] HttpResponse OutputOf(std::string_view rest, bool to_look_at) const;

  const Guard& guard_;
  Workbench& bench_;
  Json program_;
};

}  // namespace lipoid
