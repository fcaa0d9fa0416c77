// SPDX-License-Identifier: Apache-2.0
// Collects the samples of the roles of a map and masks those that are no measurement.
#pragma once
#include <map>
#include <string>

#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

class ChannelBuilder {
 public:
  /// `role` is the channel's name; `source` its entry in the map, whose limits and codes are used.
  ChannelBuilder(DriveLog& log, std::string role, const RoleSource& source, std::string described);

  /// A sample as recorded (before scale and offset of the map).
  void add(double time_s, double recorded);
  /// A sample that is no measurement, and why; `reason` is a literal.
  void mask(double time_s, const char* reason);
  /// A sample whose time is wrong: counted.
  void leave_out() { ++channel_.left_out; }
  /// Frames that the sender counted and the recording does not have.
  void add_lost_frames(double from_s, double to_s, std::size_t frames);
  /// Puts the channel into the log, with its gaps; one without any usable sample is left out and named.
  void finish();

 private:
  void extend(double time_s, const char* reason);

  DriveLog& log_;
  const RoleSource& source_;
  RoleRange range_;
  Channel channel_;
  std::vector<MaskedStretch> stretches_;
  bool open_ = false;  ///< the last sample belongs to the last stretch
  std::map<std::string, LogDefect> defects_;
  std::size_t usable_ = 0;
};

/// A clock that counts from 1970, not from a recording's own beginning [s].
[[nodiscard]] constexpr bool is_absolute(double time_s) {
  return time_s > 1e8;
}

/// Adds one source file's roles to the log. Both throw InputError for a column, frame or signal that is not there.
void add_table_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                        const std::map<std::string, RoleSource>& roles, bool main);
void add_can_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                      const std::map<std::string, RoleSource>& roles, bool main);

}  // namespace voltlap::plant
