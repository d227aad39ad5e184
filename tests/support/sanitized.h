// Whether the address sanitizer watches: it has an operator new of its own and takes terabytes of
// addresses.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define LIPOID_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LIPOID_SANITIZED 1
#endif
#endif
