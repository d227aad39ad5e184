#pragma once

/// @file
/// What a call throws, as text, so that a test can compare the whole message.

#include <exception>
#include <string>
#include <utility>

namespace lipoid::test {

/// what() of the Error that the call throws; a sentence that no message equals where it throws
/// nothing or something else.
template <class Error, class Call>
std::string MessageOf(Call&& call) {
  try {
    std::forward<Call>(call)();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& other) {
    return std::string("(an exception of another type: ") + other.what() + ")";
  }
  return "(no exception)";
}

}  // namespace lipoid::test
