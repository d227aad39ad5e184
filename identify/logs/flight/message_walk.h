#pragma once

/// @file
/// From message to message through the log of an autopilot, past what is damaged. What a message may
/// look like is said by its format; what holds for all of them stands here: after damage, reading goes
/// on where messages follow one another again, and a message that is followed by none is doubted where
/// others hold together inside it (its length is damaged, and it would swallow them). Tests:
/// tests/identify/logs/flight/autopilot_log_test.cc.

#include <cstddef>
#include <string_view>

#include "identify/logs/flight/autopilot_log.h"

namespace lipoid {

/// Of a `Format`:
///   std::size_t MessageAt(std::size_t at) const   bytes of the message that begins there; 0: none can
///   bool EndsInside(std::size_t at) const         one may begin there whose end the file lacks
///   void Take(std::size_t at, std::size_t size)
template <class Format>
class MessageWalk {
 public:
  MessageWalk(Format& format, std::string_view bytes, AutopilotLog& log)
      : format_(format), end_(bytes.size()), log_(log) {}

  void From(std::size_t at) {
    while (at < end_) {
      if (const std::size_t size = format_.MessageAt(at); size > 0 && !IsDoubtful(at, size)) {
        format_.Take(at, size);
        ++log_.messages;
        at += size;
        continue;
      }
      const std::size_t next = NextChain(at + 1, end_);
      if (next == end_ && format_.EndsInside(at)) {
        log_.cut_last_message = true;
        break;
      }
      log_.skipped_bytes += next - at;
      ++log_.damaged_places;
      at = next;
    }
  }

 private:
  // So many messages must follow one another before they are believed.
  static constexpr int kChain = 3;

  [[nodiscard]] bool IsDoubtful(std::size_t at, std::size_t size) const {
    const std::size_t after = at + size;
    if (after == end_ || format_.MessageAt(after) > 0 || format_.EndsInside(after)) return false;
    return NextChain(at + 1, after) < after;
  }

  // Where messages hold together again before `end`, or `end`.
  [[nodiscard]] std::size_t NextChain(std::size_t from, std::size_t end) const {
    for (std::size_t start = from; start < end; ++start) {
      std::size_t at = start;
      int links = 0;
      while (links < kChain && at < end_) {
        const std::size_t size = format_.MessageAt(at);
        if (size == 0) break;
        at += size;
        ++links;
      }
      if (links == kChain || (links > 0 && at == end_)) return start;
    }
    return end;
  }

  Format& format_;
  std::size_t end_;
  AutopilotLog& log_;
};

}  // namespace lipoid
