#include "model/export/zip_archive.h"

#include <zip.h>

#include <memory>
#include <stdexcept>

namespace lipoid {
namespace {

[[noreturn]] void Fail(const char* what) {
  throw std::runtime_error(std::string("libzip: ") + what);
}

}  // namespace

std::string ZipArchive(const std::vector<ZipEntry>& entries) {
  zip_error_t error;
  zip_error_init(&error);
  // The buffer is held once by the archive and once by us, to read it when the archive is closed.
  const std::unique_ptr<zip_source_t, void (*)(zip_source_t*)> buffer(
      zip_source_buffer_create(nullptr, 0, 0, &error), zip_source_free);
  if (!buffer) Fail(zip_error_strerror(&error));
  zip_source_keep(buffer.get());
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      zip_open_from_source(buffer.get(), ZIP_TRUNCATE, &error), zip_discard);
  if (!archive) {
    zip_source_free(buffer.get());
    Fail(zip_error_strerror(&error));
  }
  for (const ZipEntry& entry : entries) {
    zip_source_t* const source =
        zip_source_buffer(archive.get(), entry.content.data(), entry.content.size(), 0);
    if (source == nullptr) Fail(zip_strerror(archive.get()));
    const zip_int64_t added =
        zip_file_add(archive.get(), entry.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (added < 0) {
      zip_source_free(source);
      Fail(zip_strerror(archive.get()));
    }
    const auto index = static_cast<zip_uint64_t>(added);
    constexpr zip_uint16_t kFirstDay = 1 << 5 | 1;  // 1980-01-01, the first that a zip can hold
    constexpr zip_uint32_t kPlainFile = 0100644U << 16;
    if (zip_set_file_compression(archive.get(), index, ZIP_CM_DEFLATE, 9) != 0 ||
        zip_file_set_dostime(archive.get(), index, 0, kFirstDay, 0) != 0 ||
        zip_file_set_external_attributes(archive.get(), index, 0, ZIP_OPSYS_UNIX, kPlainFile) != 0)
      Fail(zip_strerror(archive.get()));
  }
  if (zip_close(archive.get()) != 0) Fail(zip_strerror(archive.get()));
  static_cast<void>(archive.release());  // zip_close() freed it
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(buffer.get(), &stat) != 0 || zip_source_open(buffer.get()) != 0)
    Fail(zip_error_strerror(zip_source_error(buffer.get())));
  std::string bytes(stat.size, '\0');
  const zip_int64_t read = zip_source_read(buffer.get(), bytes.data(), bytes.size());
  zip_source_close(buffer.get());
  if (read != static_cast<zip_int64_t>(bytes.size())) Fail("the archive was read in part");
  return bytes;
}

}  // namespace lipoid
