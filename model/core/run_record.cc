#include "model/core/run_record.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "generated/version.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  // OpenSSL keeps a state per thread, which a thread of a pool that outlives main() never gives back.
  ~Sha256() {
    context_.reset();
    OPENSSL_thread_stop();
  }
  void Update(const void* bytes, std::size_t size) {
    EVP_DigestUpdate(context_.get(), bytes, size);
  }
  std::string Hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &size);
    std::string hex;
    for (unsigned int k = 0; k < size; ++k) hex += fmt::format("{:02x}", digest[k]);
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace

const char* Version() { return LIPOID_VERSION; }
const char* GitCommit() { return LIPOID_GIT_COMMIT; }

std::string Sha256OfFile(const std::string& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               &std::fclose);
  if (!stream) {
    throw LoadError(NoFile(file),
                    fmt::format("expected a readable file, found none ({})", std::strerror(errno)));
  }
  Sha256 hash;
  std::vector<char> buffer(1 << 20);
  for (std::size_t got = 0;
       (got = std::fread(buffer.data(), 1, buffer.size(), stream.get())) > 0;) {
    hash.Update(buffer.data(), got);
  }
  if (std::ferror(stream.get()) != 0) {  // a folder opens, but cannot be read
    throw LoadError({file},
                    fmt::format("expected a readable file, found one that cannot be read ({})",
                                std::strerror(errno)));
  }
  return hash.Hex();
}

std::string Sha256OfBytes(const std::string& bytes) {
  Sha256 hash;
  hash.Update(bytes.data(), bytes.size());
  return hash.Hex();
}

Json RunRecord::ToJson() const {
  Json files = Json::array();
  Require(sha256.empty() || sha256.size() == inputs.size(), "a hash for every input, or none");
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    files.push_back(
        {{"file", inputs[k]}, {"sha256", sha256.empty() ? Sha256OfFile(inputs[k]) : sha256[k]}});
  }
  return {{"command", command},
          {"options", options},
          {"seed", seed},
          {"version", Version()},
          {"commit", GitCommit()},
          {"inputs", files},
          {"metrics", metrics}};
}

}  // namespace lipoid
