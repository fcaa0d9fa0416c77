// SPDX-License-Identifier: Apache-2.0
// A signal of a recording with what its name says and where its values lie.
#pragma once
#include <string>

#include "io/logs/recorded_signals.hpp"
#include "io/logs/signal_words.hpp"

namespace voltlap::plant {

/// The signal in the unit that the file gives, else in `unit`; "" for as it is.
[[nodiscard]] RoleSource source_in(const RecordedSignal& signal, const std::string& unit);

struct SignalCandidate {
  explicit SignalCandidate(const RecordedSignal& of);

  const RecordedSignal* signal;
  SpokenName name;

  /// As recorded: values below and above which two in a hundred lie.
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  [[nodiscard]] double middle() const { return middle_; }
  [[nodiscard]] bool varies() const { return high_ > low_; }

  /// By the unit that the file gives, without one by the name.
  [[nodiscard]] bool is_of(Quantity quantity, Meaning meaning) const;
  /// Never beyond what a lithium cell can have.
  [[nodiscard]] bool is_cell_voltage() const;
  [[nodiscard]] bool is_temperature() const;
  /// By name and unit, whatever its values.
  [[nodiscard]] bool is_called_temperature() const;
  /// "Ambient" and no other quantity, without a unit: in degC, by its values too.
  [[nodiscard]] bool is_called_ambient() const;
  /// "V" or "mV" by the size of the numbers where the file gives none; "" for numbers that are no battery's.
  [[nodiscard]] const char* voltage_unit() const;
  /// Volts, of a signal that is a voltage.
  [[nodiscard]] double volts(double recorded) const;

 private:
  double low_ = 0.0, high_ = 0.0, middle_ = 0.0;
};

}  // namespace voltlap::plant
