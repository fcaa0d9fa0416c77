// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_ekf.hpp"

#include "base/interpolate.hpp"
#include "base/require.hpp"
#include "bms/estimate/soc_coulomb.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int64_t kHalfUnitsPerMah = 2LL * 3'600'000LL;  // as soc_coulomb counts

// Doubt at a start from the OCV [2^-32]: half a point and what 5 mV are worth there, 5 mV a branch, the table's scale
// within 30 %.
constexpr std::int32_t kSocDoubt = 107'374;           // 0.005^2
constexpr std::int32_t kBranchDoubt = 1'717'987;      // (5 mV = 0.02 q)^2
constexpr std::int32_t kScaleDoubt = 386'547'057;     // 0.3^2
constexpr std::int32_t kFadeDoubt = 96'636'764;       // 0.15^2: a pack of some seasons
constexpr std::int64_t kDoubtedVoltage = 1'342'177;   // 0.02 q in 2^-26, as a slope

// Doubt at a start from a record: what was drawn since it was kept, and 3 points; its scale within 10 %,
// its capacity within 12.5 %.
constexpr std::int32_t kKeptSocDoubt = 3'865'471;     // 0.03^2
constexpr std::int32_t kKeptScaleDoubt = 42'949'673;  // 0.1^2
constexpr std::int32_t kKeptFadeDoubt = 67'108'864;   // 0.125^2

/// (0.02 q / slope)^2 + kSocDoubt [2^-32]; cell_filter bounds it.
std::int32_t soc_doubt(std::int32_t slope) {
  VOLTLAP_REQUIRE(slope > 0);                                   // 0.1 mV over the whole charge are 26844
  const std::int64_t share = (kDoubtedVoltage << 16) / slope;  // 2^-16
  constexpr std::int64_t kMost = 1 << 15;                       // half of the charge
  const std::int64_t inside = share > kMost ? kMost : share;
  return static_cast<std::int32_t>(inside * inside + kSocDoubt);
}

/// SOC of a count of charge at the configured capacity: 2^28 / capacity, as a mantissa of 28 bits and a shift that
/// holds for all cells.
std::int32_t per_charge(const Config& config, std::uint8_t& bits) {
  const std::int64_t full = config.capacity_mah * kHalfUnitsPerMah;
  bits = 0;
  for (std::int64_t rest = full; rest > 1; rest >>= 1) ++bits;
  // 2^(bits + 28) / full is 2^27 .. 2^28; in two steps, for the numerator may be beyond 64 bits.
  constexpr int kMost = 61;
  const int whole = bits + kUnitBits, over = whole > kMost ? whole - kMost : 0;
  return static_cast<std::int32_t>((std::int64_t{1} << (whole - over)) / (full >> over));
}

/// `interval`: where the search of the cell before it ended, and where this one's ends.
void begin_at_ocv(const Config& config, const SocInput& input, std::size_t i, std::uint8_t& interval, SocFilter& f) {
  CellFilter& cell = f.cell[i].filter;
  cell.s = filter_soc(interpolate(config.ocv.voltage, config.ocv.soc, config.ocv.count, input.cells[i].value));
  cell.v1 = cell.v2 = 0;
  if (!f.restored) cell.rho = kUnit;
  const OcvNow ocv = ocv_at(f.model, cell.s, interval);
  cell.interval = interval;
  begin_filter({soc_doubt(ocv.slope), kBranchDoubt, kBranchDoubt, kScaleDoubt, kFadeDoubt}, cell);
}

/// What a branch held may still be there, or gone: nobody knows how long the supply was off.
std::int32_t kept_branch_doubt(std::int32_t v) {
  return saturated32(std::int64_t{product(v, v, 2 * kUnitBits - kVarianceBits)} + kBranchDoubt);
}

void begin_at_record(CellFilter& cell) {
  cell.interval = 0;
  cell.from_record = true;
  begin_filter({kKeptSocDoubt, kept_branch_doubt(cell.v1), kept_branch_doubt(cell.v2), kKeptScaleDoubt,
                kKeptFadeDoubt},
               cell);
}

/// At rest a cell's voltage lies between the OCV and that less what the branches may still hold. A record that is
/// farther off than ten points tells of another time: the pack was charged, or another one.
bool contradicted(const CellModel& model, CellFilter cell, CellVoltage voltage) {
  constexpr std::int64_t kMargin = kUnit / 50;  // 5 mV
  constexpr std::int32_t kPoints = kUnit / 10;
  const auto ocv = [&](std::int32_t s) { return std::int64_t{ocv_at(model, s, cell.interval).voltage} * 4; };
  const std::int64_t v = std::int64_t{filter_voltage(voltage)} * 4, branches = std::int64_t{cell.v1} + cell.v2;
  cell.interval = 0;
  const std::int64_t low = ocv(cell.s - kPoints) - (branches > 0 ? branches : 0) - kMargin;
  const std::int64_t high = ocv(cell.s + kPoints) - (branches < 0 ? branches : 0) + kMargin;
  return v < low || v > high;
}

// BMS-082
bool record_holds(const Config& config, const SocInput& input, const SocFilter& f) {
  if (!f.restored || !at_rest(config, input.current)) return f.restored;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    if (contradicted(f.model, f.cell[i].filter, input.cells[i].value)) return false;
  }
  return true;
}

void start(const Config& config, const SocInput& input, SocEstimate& state) {
  SocFilter& f = state.filter;
  if (!grow_model(config, f.model)) return;
  if (!input.cells_good || !input.current.good() || !(f.restored || at_rest(config, input.current))) return;
  const bool from_record = record_holds(config, input, f);
  f.per_charge = per_charge(config, f.charge_bits);
  f.sum = 0;
  std::uint8_t interval = 0;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    FilteredCell& cell = f.cell[i];
    if (from_record) {
      begin_at_record(cell.filter);
    } else {
      begin_at_ocv(config, input, i, interval, f);
    }
    cell.stepped = input.now;
    cell.charge = 0;
    f.sum += cell.filter.s;
  }
  state.charge = 0;
  state.last_current = input.current;
  state.valid = true;
}

void follow_temperature(const SocInput& input, SocFilter& f) {
  if (!input.temperature_known || (f.heat_known && f.heat_of == input.temperature)) return;
  if (!f.heat_known) f.heat_began = input.temperature;
  f.heat_known = true;
  f.heat_of = input.temperature;
  f.warm = factors_of(f.model.by_temperature, input.temperature.raw());
}

/// What the cell has not counted yet; more than 32 bits of it wait for the next turn.
FilterInterval interval_of(const SocFilter& f, std::int64_t charge, Instant now, FilteredCell& cell) {
  const std::int32_t waited = (now - cell.stepped).ms();
  const std::int32_t elapsed = waited < 1 ? 1 : (waited > kElapsedMost_ms ? kElapsedMost_ms : waited);
  const std::int32_t taken = saturated32(cell.charge - charge);
  cell.charge -= taken;
  cell.stepped = now;
  return {elapsed, product(taken, f.per_charge, f.charge_bits), taken / (2 * elapsed)};
}

/// A reading that came since the cell's last turn, with the current of its time.
bool is_new(const SocInput& input, std::size_t i, const FilteredCell& cell) {
  const bool bled = input.bled != nullptr && input.bled[i];  // BMS-055
  return !bled && input.cells[i].good() && input.current.good() && (input.cells[i].time - cell.stepped).ms() > 0;
}

void step_cell(const SocInput& input, std::size_t i, SocEstimate& state) {
  SocFilter& f = state.filter;
  FilteredCell& cell = f.cell[i];
  f.sum -= cell.filter.s;
  const bool read = is_new(input, i, cell);
  predict_cell(f.model, f.warm, interval_of(f, state.charge, input.now, cell), cell.filter);
  if (read) {
    update_cell(f.model, f.warm, {input.cells[i].value, input.cell_current[i].raw()}, cell.filter);
  }
  f.sum += cell.filter.s;
}

}  // namespace

// BMS-080
void soc_ekf(const Config& config, const SocInput& input, SocEstimate& state) {
  VOLTLAP_REQUIRE(config.capacity_mah > 0 && input.cell_current != nullptr);
  if (!state.valid) {
    start(config, input, state);
  } else {
    (void)count_charge(config, input.current, state);
    follow_temperature(input, state.filter);
    for (std::uint16_t turn = cells_in_turn(config.cells_in_series); turn > 0; --turn) {
      step_cell(input, state.filter.next, state);
      state.filter.next = static_cast<std::uint16_t>((state.filter.next + 1) % config.cells_in_series);
    }
  }
  if (state.valid) state.value = reported_soc(state.filter.sum / config.cells_in_series);
}

}  // namespace voltlap::bms
