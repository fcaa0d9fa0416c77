// SPDX-License-Identifier: Apache-2.0
// The signals of a recording by name, sample by sample, whatever the recording is: CAN frames with DBC files, a table,
// or roles by a map. A recording is read as often as it is asked for; nothing of it is kept.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

struct SignalHead {
  std::string name;    ///< such as "BmsStatus.PackVoltage", or "can1:BmsStatus.PackVoltage" where two buses have it
  std::string unit;    ///< as the source has it; may be empty
  std::string source;  ///< such as "0x186, can0" or "column 3"
  std::map<double, std::string> states{};  ///< names of values
};

/// What a recording is, in words for people; complete when it has been read once.
struct RecordingFacts {
  std::string format;              ///< such as "candump, 2 buses"
  std::string start;               ///< in the recorder's own clock, in words; empty when it has none
  double duration_s = 0.0;
  std::size_t frames = 0;          ///< or rows
  std::vector<std::string> notes;  ///< defects, decisions, what could not be decoded
};

/// Number of the signal in heads(), seconds since the recording's beginning, value; NaN: a sample without a value.
using SampleSink = std::function<void(std::size_t signal, double time_s, double value)>;
/// Frames or rows read so far.
using ReadProgress = std::function<void(std::size_t frames)>;

class PlottedSignals {
 public:
  virtual ~PlottedSignals() = default;
  /// Gives every sample, in time for each signal. Numbers of signals are the same each time. Throws InputError.
  virtual void read(const SampleSink& sink, const ReadProgress& progress) = 0;
  /// The signals that were heard so far.
  [[nodiscard]] virtual const std::vector<SignalHead>& heads() const = 0;
  /// Names that the DBC files have and the recording has not, for messages.
  [[nodiscard]] virtual std::vector<std::string> silent() const { return {}; }
  [[nodiscard]] virtual const RecordingFacts& facts() const = 0;
};

struct SignalSources {
  std::string recording;
  std::vector<std::string> dbc_files;
  std::string map;  ///< name or path of a role map; empty: none. Beside DBC files only its intervals count
};

/// Opens what fits: roles when there is a map, frames with the DBC files, a table with its columns. A CAN recording
/// without either is read by the shipped map that fits. Throws InputError.
[[nodiscard]] std::unique_ptr<PlottedSignals> open_signals(const SignalSources& sources, const DataFolder& data);

/// Day and time of a clock that counts from 1970; empty for any other.
[[nodiscard]] std::string start_text(double begin_s);

[[nodiscard]] std::unique_ptr<PlottedSignals> can_signals(const SignalSources& sources, const DataFolder& data);
[[nodiscard]] std::unique_ptr<PlottedSignals> table_signals(const std::string& path);
[[nodiscard]] std::unique_ptr<PlottedSignals> role_signals(const SignalSources& sources, const DataFolder& data);

}  // namespace voltlap::plant
