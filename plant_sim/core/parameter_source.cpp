// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_source.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>

#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

using Lines = std::vector<std::string>;

/// Files are read once each; one that can no longer be read has no lines.
class SourceFiles {
 public:
  const std::string& line(const std::string& path, std::size_t number) {
    auto [file, fresh] = files_.try_emplace(path);
    if (fresh) {
      std::ifstream in(path);
      for (std::string text; std::getline(in, text);) file->second.push_back(text);
    }
    return number >= 1 && number <= file->second.size() ? file->second[number - 1] : none_;
  }

 private:
  std::map<std::string, Lines> files_;
  std::string none_;
};

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// Of `value  # unit; source` the source, of `value  # words` the words. A # inside a quoted value is not a
/// comment.
std::string comment_source(const std::string& line) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] != '#' || quoted) continue;
    const std::size_t semicolon = line.find(';', i);
    return trimmed(line.substr(semicolon == std::string::npos ? i + 1 : semicolon + 1));
  }
  return {};
}

void add_place(const std::string& origin, SourceFiles& files, ParameterSource& into) {
  if (origin.starts_with("--set")) {
    into.place = "--set";
    return;
  }
  const std::size_t colon = origin.rfind(':');
  std::size_t number = 0;
  if (colon != std::string::npos) std::from_chars(origin.data() + colon + 1, origin.data() + origin.size(), number);
  into.place = std::filesystem::path(origin).filename().string();
  into.source = comment_source(files.line(origin.substr(0, colon), number));
}

}  // namespace

std::vector<ParameterSource> parameter_sources(const LoadedVehicle& car) {
  std::vector<ParameterSource> out;
  SourceFiles files;
  for (const auto& [key, value] : parameter_values(car.parameters)) {
    ParameterSource entry{.key = key, .value = value, .unit = {}, .meaning = {}, .place = "default", .source = {}};
    if (const ParameterRow* row = find_parameter(key)) {
      entry.unit = row->unit;
      entry.meaning = row->description;
    }
    for (const IndexedRow& row : indexed_rows()) {
      if (!entry.meaning.empty() || !key.starts_with(row.prefix)) continue;
      if (!key.ends_with("." + std::string(row.field))) continue;
      entry.unit = row.unit;
      entry.meaning = row.description;
    }
    if (const auto origin = car.origin.find(key); origin != car.origin.end())
      add_place(origin->second, files, entry);
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace voltlap::plant
