#pragma once

/// @file
/// Every row of a log, in blocks: for what is written or compared row by row. A log that ReadLog() kept
/// as it is comes as one block; of one that it thinned the file is read once more, with what was
/// settled by the whole of it. Both give the same rows, bit for bit.
/// Tests: tests/identify/logs/all_rows_test.cc.

#include <functional>

#include "identify/logs/log.h"

namespace lipoid {

/// take(rows) for each block, in order; rows are those of the pack, as in `log`, which ReadLog() read
/// by `options`. They may be changed: `log` itself loses its rows where they are handed on. LoadError
/// where the file cannot be read twice or has changed.
void ForEachBlockOfRows(Log& log,
                        const ReadOptions& options,
                        const std::function<void(Record& rows)>& take);

}  // namespace lipoid
