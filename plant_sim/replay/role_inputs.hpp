// SPDX-License-Identifier: Apache-2.0
// The roles of a recording as what the firmware's sensors would read, each with its real age; and in words what stands
// for the roles that the recording does not have.
#pragma once
#include <string>
#include <vector>

#include "replay/firmware_watch.hpp"
#include "replay/held_channel.hpp"
#include "replay/input_frames.hpp"

namespace voltlap::plant {

/// What the replay knows of the car, beside the recording.
struct ReplayCar {
  std::size_t cells = 0, thermistors = 0;   ///< as the firmware is configured
  double motor_constant_nm_per_a = 0.0;
  double full_brake_bar = 0.0;              ///< at a brake pedal of 1
  double rest_current_a = 1.0;              ///< below it the cells count as at rest
  double cell_min_v = 0.0, cell_max_v = 0.0;
  bool carry_cells = true;                  ///< slow cell voltages follow the pack's between their samples
  double hold_intervals = 5.0;              ///< a slow channel is held for so many of its usual intervals
  double capacity_ah = 0.0;                 ///< 0: not known
  double resistance_ohm = 0.0;              ///< of a cell, as the firmware has it; 0: not known
  std::vector<std::pair<double, double>> ocv{};  ///< SOC and V, rising; empty: not known
};

class RoleInputs {
 public:
  /// Throws InputError for a recording without current, or without any voltage that could be a cell's.
  RoleInputs(const DriveLog& log, const ReplayCar& car);
  RoleInputs(const RoleInputs&) = delete;  // a held channel looks at bus_
  RoleInputs& operator=(const RoleInputs&) = delete;

  /// The first moment at which everything is known and, within ten seconds, the current is at rest.
  [[nodiscard]] double begin_s() const { return begin_s_; }
  [[nodiscard]] double end_s() const { return end_s_; }
  /// There the cells carry more than a current of rest.
  [[nodiscard]] bool begins_under_load() const { return begins_under_load_; }
  [[nodiscard]] double recorded_from_s() const { return current_.first_s(); }
  [[nodiscard]] const std::vector<std::string>& assumptions() const { return assumptions_; }

  /// Forwards only.
  void advance(double time_s);
  /// Without contacts, DC link and switches: they are not in the recording.
  [[nodiscard]] Readings readings();
  [[nodiscard]] double cell(std::size_t index);
  /// Before the first moment of a recording that begins under load, all cells at one voltage; as recorded by NaN.
  void show_alike(double cell_v) { alike_v_ = cell_v; }
  [[nodiscard]] double thermistor(std::size_t index);
  [[nodiscard]] double current_a() const { return current_.known() ? current_.value() : kUnknown; }
  /// Everything that the recording says; looks at every cell.
  [[nodiscard]] LoggedMoment moment();

 private:
  struct Cell {
    HeldChannel voltage{};
    double taken_s = -1e300, pack_then_v = kUnknown;  ///< of the sample that is held
    double share = 1.0;                               ///< of the pack's change, against that of a mean cell
  };
  void take_battery(const DriveLog& log);
  void take_cells(const DriveLog& log);
  void take_temperatures(const DriveLog& log);
  void take_motion(const DriveLog& log);
  void choose_pack_voltage(const DriveLog& log);
  void find_begin();
  void find_end();
  void find_rest();
  [[nodiscard]] bool is_settled(double time_s) const;
  [[nodiscard]] HeldChannel channel(const DriveLog& log, const std::string& role, std::int32_t timeout_ms) const;
  void take_once(const DriveLog& log, std::vector<std::pair<int, const Channel*>>& numbered);
  void learn_shares(const std::vector<std::pair<int, const Channel*>>& numbered);
  void level_cells();
  [[nodiscard]] double longest_s(const std::vector<const Channel*>& channels, std::int32_t timeout_ms) const;
  [[nodiscard]] double pack_v();
  [[nodiscard]] double recorded_pack_v();
  [[nodiscard]] double recorded_cell(std::size_t index);
  void assume(std::string text) { assumptions_.push_back(std::move(text)); }

  ReplayCar car_;
  double now_s_ = 0.0, begin_s_ = 0.0, end_s_ = 0.0, levelling_v_ = 0.0, next_levelling_s_ = -1e300;
  double alike_v_ = kUnknown;
  std::vector<Channel> once_{};  ///< cells without the readings that the logger repeats
  Channel bus_{};  ///< stands for the pack's voltage where that is not recorded
  const Channel* pack_channel_ = nullptr;
  bool carries_ = false, shared_pack_ = false, begins_under_load_ = false;
  HeldChannel current_, pack_, motor_speed_, motor_torque_, motor_current_, accelerator_, brake_, brake_pressure_;
  HeldChannel soc_, discharge_limit_, charge_limit_;
  std::vector<Cell> cells_;
  std::vector<HeldChannel> temperatures_, wheels_;
  std::vector<std::string> assumptions_;
};

/// Numbers of cells and thermistors that a recording has a usable channel of.
[[nodiscard]] std::size_t recorded_cells(const DriveLog& log);
[[nodiscard]] std::size_t recorded_thermistors(const DriveLog& log);

}  // namespace voltlap::plant
