#pragma once

/// @file
/// Exact texts of errors, for tests.

#include <string>

#include "model/core/errors.h"

namespace lipoid::test {

/// what() of the LoadError that the call throws; "no error" where it does not throw.
template <class Call>
std::string LoadErrorOf(Call&& call) {
  try {
    call();
  } catch (const LoadError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace lipoid::test
