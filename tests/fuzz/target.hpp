// SPDX-License-Identifier: Apache-2.0
// The readers of the project, each as something that takes a file of any content. What was read must hold together, or
// InputError says why not. A new reader is a row in target.cpp.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace voltlap::plant {

struct FuzzTarget {
  std::string_view name;
  std::string_view file;     ///< name that the input has as a file: some readers go by its ending
  std::size_t longest;       ///< bytes of a drawn input
  void (*read)(const std::string& path);
  double slowest_s = 2.0;    ///< processor time for a megabyte, and for less of it
};

[[nodiscard]] std::span<const FuzzTarget> targets();
/// nullptr: none of that name.
[[nodiscard]] const FuzzTarget* find_target(std::string_view name);

// Tables and lines.
void read_lines(const std::string& path);
void read_measured(const std::string& path);
void read_input_table(const std::string& path);
// Recordings.
void read_can(const std::string& path);
void read_dbc(const std::string& path);
void read_role_map(const std::string& path);
void read_drive_recording(const std::string& path);
void read_cell_recording(const std::string& path);
// Courses and drives.
void read_track(const std::string& path);
void read_course(const std::string& path);
void read_gpx_course(const std::string& path);
void import_small_course(const std::string& path);
void read_drive(const std::string& path);
void read_run(const std::string& path);
// Parameters.
void read_vehicle(const std::string& path);
void read_cell(const std::string& path);
void read_settings(const std::string& path);
void read_plan(const std::string& path);

/// Text of a file, for inputs that are several in one.
[[nodiscard]] std::string content_of(const std::string& path);

}  // namespace voltlap::plant
