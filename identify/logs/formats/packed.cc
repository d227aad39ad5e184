#include "identify/logs/formats/packed.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/core/errors.h"

namespace lipoid {
namespace {

using namespace std::string_view_literals;

struct Packed {
  std::string_view magic;
  std::string_view what;
  std::string_view advice;
  std::size_t offset = 0;
};

constexpr std::string_view kUnpack = "unpack it and name the log inside";
constexpr std::string_view kSaveAsCsv = "save the sheet as CSV";
constexpr std::string_view kExportCsv = "write the columns time, current and voltage to CSV";

constexpr Packed kPacked[] = {
    {"BIO-LOGIC MODULAR FILE"sv,
     "a BioLogic binary file (.mpr)",
     "export it as text (.mpt) in EC-Lab or BT-Lab"},
    {"\x1f\x8b"sv, "a gzip file", kUnpack},
    {"BZh"sv, "a bzip2 file", kUnpack},
    {"\xFD\x37zXZ\0"sv, "an xz file", kUnpack},
    {"\x28\xB5\x2F\xFD"sv, "a zstd file", kUnpack},
    {"7z\xBC\xAF\x27\x1C"sv, "a 7z archive", kUnpack},
    {"Rar!\x1A"sv, "a rar archive", kUnpack},
    {"ustar"sv, "a tar archive", kUnpack, 257},
    {"Standard Jet DB"sv,
     "an Access database (Arbin .res or .mdb)",
     "export the channel as CSV in Arbin MITS Pro",
     4},
    {"Standard ACE DB"sv,
     "an Access database (.accdb)",
     "export the channel as CSV in Arbin MITS Pro",
     4},
    {"NEWARE"sv, "a Neware binary file (.nda)", "export it as CSV in BTSDA"},
    {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"sv, "an old Office document (.xls)", kSaveAsCsv},
    {"MATLAB 5.0 MAT-file"sv, "a MATLAB file (.mat)", kExportCsv},
    {"MATLAB 7.3 MAT-file"sv, "a MATLAB file (.mat)", kExportCsv},
    {"\x89HDF\r\n\x1a\n"sv, "an HDF5 file", kExportCsv},
    {"PAR1"sv, "a Parquet file", kExportCsv},
    {"ARROW1"sv, "an Arrow file", kExportCsv},
    {"SQLite format 3"sv, "an SQLite database", kExportCsv},
    {"TDSm"sv, "a LabVIEW binary file (.tdms)", kExportCsv},
    {"%PDF-"sv, "a PDF document", "export the data of the test as CSV"},
    {"\xFF\xFE"sv, "UTF-16 text", "save it as UTF-8"},
    {"\xFE\xFF"sv, "UTF-16 text", "save it as UTF-8"},
    {"version https://git-lfs"sv, "a Git LFS pointer", "fetch the file itself with `git lfs pull`"},
    {"<!DOCTYPE"sv, "a web page", "download the file itself"},
    {"<html"sv, "a web page", "download the file itself"},
};

bool Contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

[[noreturn]] void Refuse(const std::string& file, std::string_view what, std::string_view advice) {
  throw LoadError({file}, fmt::format("expected a log as text, found {}; {}", what, advice));
}

}  // namespace

void RefusePacked(const std::string& file, std::string_view head) {
  constexpr std::size_t kLookedAt = 1 << 16;
  if (head.starts_with("PK\x03\x04") || head.starts_with("PK\x05\x06")) {
    if (Contains(head, "xl/") || Contains(head, "[Content_Types]"))
      Refuse(file, "an Excel workbook (.xlsx)", kSaveAsCsv);
    if (Contains(head, ".ndc") || Contains(head, "VersionInfo.xml") ||
        Contains(head, "TestInfo.xml")) {
      Refuse(file, "a Neware packed file (.ndax)", "export it as CSV in BTSDA");
    }
    Refuse(file, "a zip archive", kUnpack);
  }
  for (const Packed& packed : kPacked) {
    if (head.size() > packed.offset && head.substr(packed.offset).starts_with(packed.magic)) {
      Refuse(file, packed.what, packed.advice);
    }
  }
  // Text has no control bytes but these, and binary data show them soon; a NUL or two stand in the
  // preambles of some cyclers.
  head = head.substr(0, kLookedAt);
  const auto odd = std::count_if(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && c != '\n' && c != '\r' && c != '\t' && c != '\f';
  });
  constexpr std::ptrdiff_t kOneIn = 50;
  if (odd * kOneIn > static_cast<std::ptrdiff_t>(head.size())) {
    // What every message of a DataFlash log begins with, of which chance makes one in 65536 bytes.
    constexpr std::string_view kMessage = "\xA3\x95";
    constexpr std::size_t kFewest = 5;
    std::size_t messages = 0;
    for (std::size_t at = head.find(kMessage); at != head.npos && messages < kFewest;
         at = head.find(kMessage, at + kMessage.size()))
      ++messages;
    if (messages == kFewest) {
      Refuse(file,
             "an ArduPilot DataFlash log without its beginning, which says what its messages hold",
             "copy the whole log from the autopilot");
    }
    Refuse(file, "binary data", "export it as text (CSV) from the program that wrote it");
  }
}

}  // namespace lipoid
