// SPDX-License-Identifier: Apache-2.0
// Where one role of a role map comes from: a column of a table or a signal of a CAN frame.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

enum class DischargeSign { kPositive, kNegative, kAuto };
enum class FrameChecksum { kNone, kOrion, kSum, kCrc8 };

struct RoleSource {
  std::string column;
  double scale = 1.0, offset = 0.0;  ///< raw to SI: raw * scale + offset
  DischargeSign discharge = DischargeSign::kAuto;
  std::string unit{};  ///< as it was told by the map or by the column's name; empty: told by nobody

  std::optional<std::uint32_t> frame{};  ///< identifier, bit 31 set for 29 bits; none: the source is a column
  std::optional<std::uint32_t> last_frame{};  ///< numbers go on from frame to frame up to this one; flags as `frame`
  std::string signal{}, dbc{};           ///< of the frame; the path as it stands in the map
  std::string bus{};                     ///< interface or channel that the frame is on; empty: the only one
  std::optional<double> period_s{};      ///< between its frames, for recordings without stamps
  FrameChecksum checksum = FrameChecksum::kNone;
  std::string counter{};  ///< signal that counts the frames

  std::string index{};          ///< column or signal that says which <n> a value belongs to
  std::optional<long> first{};  ///< index or number in the name for <n> = 1; none: index 0 of a frame, else 1
  std::string file{};  ///< another recording of the same run, as it stands in the map; empty: the recording itself
  std::string time{};  ///< its time column; empty: the same name as in the recording itself
  bool optional = false;  ///< a table without the column is read without the role
  double shift_s = 0.0;                ///< added to that recording's clock
  std::optional<double> min{}, max{};  ///< SI; values beyond are masked. None: those of the role
  std::vector<double> invalid{};       ///< as recorded; values that mean "no value"
};

/// Whether a name is a role, or a numbered role with <n> for all of them at once, such as cell_voltage_<n>.
[[nodiscard]] bool is_role(std::string_view name);
[[nodiscard]] std::vector<std::string_view> role_names();
/// What a role can be at all, SI; beyond it a value is masked.
struct RoleRange {
  double min, max;
};
[[nodiscard]] RoleRange role_range(std::string_view role);

/// Names that hold <n> for a number: cell_voltage_<n> with 12 is cell_voltage_12.
[[nodiscard]] bool is_numbered(std::string_view pattern);
[[nodiscard]] std::string with_number(std::string pattern, long n);
/// The number for which the pattern gives that name, leading zeros allowed; nothing when it does for none.
[[nodiscard]] std::optional<long> number_in(std::string_view pattern, std::string_view name);

struct Unit {
  std::string_view name;
  double scale, offset;
  std::string_view quantity;  ///< such as "voltage"; empty: of any
};
/// Throws InputError that lists the units there are.
[[nodiscard]] Unit unit_of(const std::string& place, const std::string& name);
/// Whether a role can be measured in that unit, and all names of units in which it can.
[[nodiscard]] bool unit_fits(const Unit& unit, std::string_view role);
[[nodiscard]] std::vector<std::string_view> units_of(std::string_view role);

}  // namespace voltlap::plant
