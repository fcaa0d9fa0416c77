// SPDX-License-Identifier: Apache-2.0
// Cells as they stand at rest. A bleed's current flows through the wires that a cell is read by, so that a bled cell
// reads too low: a look takes no sample under a bleed, and such samples are marked for everybody else.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// After ingest: which cells are read under a bleed now.
void mark_bled_cells(const Config& config, Instant now, State& state);

/// While current flows: the highest of the cells' means, for the highest of single readings is what the noise makes of
/// it. `begin`: they begin anew.
void follow_highest(const Config& config, bool begin, State& state);

/// After a charge: no cell has more than what lies above the lowest, less what a rest of 20 s has left to relax.
void set_floor(CellLook& look);
/// The cell that stands farthest from the mean of the last look.
[[nodiscard]] std::uint8_t farthest_cell(const Config& config, const CellLook& look);

/// Forgets the samples of a look that has not been completed.
void begin_look(CellLook& look);
/// Takes the samples of this step in. True when every cell has enough of them: the look is complete.
[[nodiscard]] bool take_look(const Config& config, State& state);

}  // namespace voltlap::bms
