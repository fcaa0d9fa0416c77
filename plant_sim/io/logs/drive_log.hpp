// SPDX-License-Identifier: Apache-2.0
// One recording of a cell, a pack or a car as signals by role, from tables and CAN recordings alike. Each signal
// keeps its own source's rate and time stamps: nothing is interpolated, so that no delay is hidden and none is
// made.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "io/logs/frame_account.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

/// A stretch of a signal that is not used, and why.
struct MaskedStretch {
  std::string channel;
  double start_s = 0.0, end_s = 0.0;
  std::string reason;
  std::size_t count = 0;  ///< samples; 0 for a gap, which has none
};

/// SI, discharge current positive, SOC and pedals 0..1, degC.
struct Channel {
  std::string role;
  std::string source;          ///< such as "0x6B0 PackCurrent" or "column i_a"
  std::vector<double> time_s;  ///< never decreasing; of the recording's clock, see DriveLog::origin_s
  std::vector<double> value;   ///< NaN where masked
  std::size_t left_out = 0;    ///< samples of the file that are not here: their time goes back

  [[nodiscard]] std::size_t size() const { return time_s.size(); }
};

/// Something that is wrong with a recording, by kind, with its size; the words for a report are in `text`.
struct LogDefect {
  std::string kind, channel;  ///< channel empty: of the whole recording
  std::size_t count = 0;
  double first_s = 0.0;
  std::string text;
};

struct DriveLog {
  std::string path, map;
  double origin_s = 0.0;  ///< absolute clock of the recording at time 0; 0 for clocks of their own
  std::map<std::string, Channel> channels;
  std::vector<MaskedStretch> masked;  ///< by channel, then by time
  std::vector<LogDefect> defects;
  std::vector<double> restarts_s;     ///< where the recorder began anew: what lay before is not known
  std::vector<std::string> absent;  ///< roles of the map of which the recording has no sample at all
  bool temperatures_of_core = false;  ///< of the cells within, not where a thermistor sits
  bool published_is_no_measurement = false;  ///< the pack's voltage rises with the discharge current, the bus's falls
  std::vector<std::string> notes;   ///< decisions in words: sign of the current, joined recordings
  FrameAccount frames;              ///< of the recording and of what its map joins
  DischargeSign declared = DischargeSign::kAuto;
  bool sign_contradicted = false;  ///< the voltage rises with the current although the map declares its sign

  [[nodiscard]] const Channel* find(const std::string& role) const;
  /// Channels of a numbered role such as "cell_voltage_", by number: {n, channel}.
  [[nodiscard]] std::vector<std::pair<int, const Channel*>> numbered(const std::string& stem) const;
};

/// Reads a table or a CAN recording and what its map joins from other files. Without a map: the plain column names
/// or the shipped map that fits. Throws InputError for what cannot be read, for a map whose column or signal is not
/// there, and for a recording in which no role has a value; what it does not know it answers with a draft map.
[[nodiscard]] DriveLog read_drive_log(const std::string& path, const RoleMap* map, const DataFolder& data);

/// The map for a recording without a map of its own: the shipped one that it fits; for a table else what role_map_for
/// finds. With the DBC files of a CAN recording the map is proposed from their signals, see propose_map. Throws
/// InputError with a draft where a choice is left open.
[[nodiscard]] RoleMap role_map_for_recording(const std::string& path, const DataFolder& data,
                                             const std::vector<std::string>& dbc_files = {});

/// The same for a drive without DBC files. A table that no shipped map knows gives all that its columns say, see
/// drive_columns.hpp; a cell's test asks for less.
[[nodiscard]] RoleMap role_map_for_drive(const std::string& path, const DataFolder& data);

/// Value of a channel at each time: of its latest usable sample, NaN before the first and when it is older than
/// `longest_s`. A hold, as a receiver on the bus has it.
[[nodiscard]] std::vector<double> held_at(const Channel& channel, const std::vector<double>& time_s,
                                          double longest_s);

/// How clearly a voltage rises with a current, -1 to 1; negative when discharge is positive.
[[nodiscard]] double sign_evidence(const Channel& current, const Channel& voltage);

/// The same by the charge that has flowed: -1 where the voltage of an unloaded battery ends lower than it began while
/// the current is positive on the whole, 1 where higher; where it stands still, a drive draws more than it feeds back.
/// 0 where as much flows one way as the other.
[[nodiscard]] double charge_evidence(const Channel& current, const Channel& voltage);

}  // namespace voltlap::plant
