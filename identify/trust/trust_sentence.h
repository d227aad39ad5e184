#pragma once

/// @file
/// What a user should do next, in one sentence: which parameters cannot be told apart by these
/// logs, and which experiment would tell them. The physics is in the names: beta, r_s, r_j, tau_j,
/// c_j, alpha. Tests: tests/identify/trust/trust_sentence_test.cc.

#include <string>

#include "identify/trust/trust.h"

namespace lipoid {

[[nodiscard]] std::string TrustSentence(const TrustReport& report);

}  // namespace lipoid
