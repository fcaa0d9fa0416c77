// SPDX-License-Identifier: Apache-2.0
// The flags by which a role map is made for a recording that has none: --dbc and --write-map.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/logs/role_map.hpp"

namespace voltlap::plant {

struct MapFinding {
  std::vector<std::string> dbc_files;
  std::string write_map;

  void add(CLI::App& command);
  [[nodiscard]] bool is_asked() const { return !dbc_files.empty() || !write_map.empty(); }

  /// Throws InputError where every recording has a --map, so that these flags do nothing.
  void check_needed(bool every_file_has_a_map) const;
  /// The map proposed for a recording, also written to --write-map; nothing without these flags. Throws InputError
  /// for a recording that leaves a choice open, after its draft is written.
  [[nodiscard]] std::optional<RoleMap> find(const std::string& recording) const;
  /// The same without writing it: of further recordings.
  [[nodiscard]] std::optional<RoleMap> find_only(const std::string& recording) const;
  /// The map's text: for programs that take a map by its file.
  [[nodiscard]] std::string text(const std::string& recording) const;
};

/// A text in a file of its own for as long as this lives.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& text);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace voltlap::plant
