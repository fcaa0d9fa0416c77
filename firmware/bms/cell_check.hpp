// SPDX-License-Identifier: Apache-2.0
// A cell's channel against the others and against the cell's own simple model.
//
//   answer: x, y_k and z are current, voltage of the cell and of the pack in one step, each less its mean over 1.6 s, x
//           after a lag of 0.3 s; cov() their covariance over 4 s, over the steps of this cell's samples. Of the pack's
//           answer cov(x, z) the cell that sags most has the share s, each of the others its part of the rest:
//           (n - 1) cov(x, y_k) = (1 - s) cov(x, z), whatever the current does and however often the cell is read. A
//           channel that has less than a third of its part, in five samples one after the other, is
//           frozen. The lag takes out what changes faster than a channel follows: one with a lag of tau gives
//           (1 + w^2 0.3 s tau) / (1 + w^2 tau^2) of its share at w, no less than all of it up to 0.3 s. A cell that is
//           read every 30 or 100 ms sees a faster current as anything; so z is taken after the same lag, too, and the
//           smaller of the two answers is what a cell must have its part of.
//           A current that is chopped about as often as a cell is read shows it at any moment of a period, which
//           drifts: one that moves by a third of its part in whatever way is not frozen while what a lag of 50 ms takes
//           out of the current is a third of what that of 0.3 s leaves.
//           Judged while the current explains what the pack does: E = cov(x, z)^2 / cov(x, x) is at least (5 mV n)^2,
//           and a quarter of cov(z, z); and while the lag leaves a quarter of what the current does.
//   level:  l_k = mean of V_k + R I over 10 s, less that of the neighbours. It may be what the cell's own start and
//           capacity explain: OCV(s + own +- (0.03 + 0.25 drawn)) - OCV(s) +- (30 mV + 0.5 R |I|), s the SOC that
//           the neighbours' level belongs to, drawn its change since the first rest, own the cell's difference then
//           (0.1 at most). A cell that answers with more than its share may lie so much lower,
//           and in a charge so much higher.
//           Not judged where the lag leaves less than a quarter of the current and the rest moves a cell by 10 mV,
//           or moves it by 100 mV whatever the lag leaves: a part of R answers slower than that.
// The neighbours' mean level leaves out the lowest cell, so that a bad cell accuses no sound one. Chosen on drawn sound
// packs (tests/closed_loop/sound_cars_test.cpp, sound_pedals_test.cpp).
// What cannot be seen: two channels exchanged before power-on, and an error below the band. Both leave the lowest and
// the highest voltage, on which limits and trips rest, within the band.
#pragma once
#include <cstdint>

#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/covariance.hpp"

namespace voltlap::bms {

struct State;

/// What is remembered of one channel.
struct CellTrack {
  Instant time{};               ///< of the last sample that is in it
  std::int32_t voltage = 0;     ///< [0.1 mV / 256] mean over 1.6 s
  std::int32_t level = 0;       ///< [0.1 mV / 256] mean of V + R I over 10 s
  std::int32_t pack = 0;        ///< [0.1 mV] mean of the pack's voltage in the steps of these samples
  Covariance pack_answer{};     ///< over 4 s, x against that of the pack
  std::int32_t lagged_mean = 0; ///< [0.1 mV] of z after the lag
  std::int64_t x_lagged = 0;    ///< [mA 0.1 mV] x against it
  std::int32_t y_mean = 0;      ///< [0.1 mV / 256] over 4 s
  std::int64_t xy = 0;          ///< [mA 0.1 mV / 256] x against that of the cell
  std::int64_t yy = 0;          ///< [(0.1 mV)^2 / 16] of the cell alone
  Soc start{};                  ///< of the voltage at the first rest
  std::uint8_t no_answer = 0;   ///< samples in a row that say so
  std::uint8_t off_level = 0;
  bool begun = false;
};

/// Current and pack voltage, with every reading.
struct PackWave {
  Instant time{};
  LastShare lag{}, fast{}, memory{}, soon{};
  std::int32_t lagged = 0, mean = 0, x = 0;    ///< [mA]
  std::int32_t followed = 0;                   ///< [mA] after 50 ms
  std::int64_t chopped = 0;                    ///< [mA^2] mean of (I - that)^2 over 4 s
  std::int64_t all = 0, slow = 0;              ///< [mA^2] means of (I - mean)^2 and of x^2 over 4 s
  std::int32_t pack_lagged = 0, pack_mean = 0, z = 0;  ///< [0.1 mV]
  bool begun = false;
};

inline constexpr std::int32_t kAllAnswers = 1'000;

/// Written by cell_check.
struct CellCheck {
  CellTrack cell[kMaxCells] = {};
  LastShare fast{}, slow{}, memory{};  ///< of the cells' means
  PackWave wave{};
  // renewed at 10 Hz
  Instant renewed{};
  std::int32_t load = 0;         ///< [mA] mean of |I| over 10 s
  Resistance resistance{};       ///< of a cell, as the pack answered last
  std::int32_t sag = 0;          ///< [0.1 mV] R load, R the larger one of that and the table's
  std::int32_t net = 0;          ///< [mA] mean of I over 10 s
  std::int32_t rise = 0;         ///< [0.1 mV] R times what is charged on the whole, 0 otherwise
  std::int32_t level = 0;        ///< of the neighbours
  std::int32_t rest = kAllAnswers;   ///< [per mille] of the pack's answer, without the cell that sags most
  Soc start{};                   ///< mean at the first rest
  Soc soc{};                     ///< that the level belongs to
  bool chopped = false;          ///< no level can be judged
  bool based = false;            ///< the first rest has been seen
  std::uint8_t frozen = kNoCell;     ///< a channel that is, or kNoCell
  std::uint8_t off_level = kNoCell;
};

/// Takes in and judges the cells of this step; `slow`: renews what the neighbours say.
void check_cells(const Config& config, Instant now, bool slow, State& state);

}  // namespace voltlap::bms
