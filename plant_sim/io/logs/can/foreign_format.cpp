// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/foreign_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/errors.hpp"
#include "core/input_files.hpp"
#include "io/byte_source.hpp"
#include "io/python_module.hpp"
#include "io/temporary_folder.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kHead = 4096;

std::string head_of(const std::string& path) {
  ByteSource source(path, "a recording");
  std::string head(kHead, '\0');
  std::size_t size = 0;
  while (size < head.size()) {
    const std::size_t got = source.read({head.data() + size, head.size() - size});
    if (got == 0) break;
    size += got;
  }
  head.resize(size);
  return head;
}

/// What the module said on its last line.
void take_tally(std::string_view words, ForeignRecording& out) {
  while (words.ends_with('\n')) words.remove_suffix(1);
  const auto tally = nlohmann::json::parse(words.substr(words.rfind('\n') + 1), nullptr, false);
  if (!tally.is_object()) return;
  out.format = tally.value("format", "");
  const auto skipped = tally.value("skipped", nlohmann::json::object());  // outlives its items
  for (const auto& [kind, count] : skipped.items()) {
    if (count.is_number_unsigned()) out.skipped.push_back({kind, count.get<std::size_t>()});
  }
}

std::string first_line(const std::string& words, std::string_view holds) {
  const std::size_t at = words.find(holds);
  if (at == std::string::npos) return "a recording that breaks off";
  const std::size_t end = words.find('\n', at);
  return words.substr(at, end == std::string::npos ? end : end - at);
}

/// Packed and binary content has control characters all over; a text that a logger has damaged has some. A table in
/// UTF-16 has a byte order mark.
bool is_binary(std::string_view head) {
  if (head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF")) return false;
  const auto controls = std::count_if(head.begin(), head.end(), [](unsigned char c) {
    return c < ' ' && c != '\t' && c != '\n' && c != '\r' && c != '\x1b';
  });
  constexpr std::ptrdiff_t kShare = 50;  // one in so many
  return kShare * controls > std::ssize(head);
}

}  // namespace

bool may_be_foreign(const std::string& path) {
  const std::string head = head_of(path);
  if (is_binary(head)) return true;
  constexpr std::array<std::string_view, 7> kFirstWords{";$FILEVERSION",  ";###",
                                                        "***BUSMASTER",   "Time Stamp,ID,",
                                                        "timestamp,arbitration_id", "File created on ",
                                                        "<?xml"};
  std::string_view text = head;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(" \t\r\n")));
  return std::any_of(kFirstWords.begin(), kFirstWords.end(),
                     [&](std::string_view words) { return text.starts_with(words); });
}

const ForeignRecording& read_foreign(const std::string& path) {
  static const TemporaryFolder workshop;
  static std::map<std::string, ForeignRecording> read;
  std::error_code ignored;
  const std::string whole = std::filesystem::weakly_canonical(path, ignored).string();
  if (const auto at = read.find(whole); at != read.end()) return at->second;
  ForeignRecording out;
  out.candump = fmt::format("{}/{}.log", workshop.path(), read.size());
  note_input(path);
  const PythonReport report = run_recording_module("voltlap_logs.frames", {path}, {{}, out.candump});
  take_tally(report.words, out);
  if (report.broke_off) out.broken = first_line(report.words, "breaks off");
  return read.emplace(whole, std::move(out)).first->second;
}

}  // namespace voltlap::plant
