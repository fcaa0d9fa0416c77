// SPDX-License-Identifier: Apache-2.0
// What identify writes, read back as the rest of the product reads it, and run over the recordings that it was made of:
// the RMS that is printed is that of the file, and a file that is not to be trusted is refused.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "learn/identify/cell_identification.hpp"

namespace voltlap::plant {

/// A cell file's text through the product's own loader. Throws InputError where the product refuses it.
[[nodiscard]] CellParameters read_back(const std::string& toml, const DataFolder& data);

/// Errors of the file in place of the fit's, in every recording of `identified` and over each of its points: lookup by
/// the recorded temperature, the file's own warming where there is none, branches at rest where a recording begins.
/// `each`: the cells that `identified` is of, one or the several of a mean.
void take_errors_of_file(const CellParameters& file, const std::vector<CellIdentification>& each,
                         CellIdentification& identified);

/// Throws InputError for an open-circuit voltage, a resistance or a time constant that no cell has. `cells_in_series`:
/// that the recordings were read with.
void require_possible_cell(const CellParameters& file, const CellIdentification& identified, int cells_in_series);

/// RMS [V] by which the file misses a recording at most, of those that it misses by twice as much as the fit did; 0 for
/// none.
[[nodiscard]] double lost_by_file(const CellIdentification& identified);

/// Throws InputError for a recording whose SOC by the capacity that was found is none.
void require_possible_soc(const CellIdentification& identified);

/// Throws InputError for a recording that the file misses: half of its rows by more than 150 mV, or all with more than
/// five times the fit's RMS and 20 mV.
void require_file_follows(const CellIdentification& identified);

}  // namespace voltlap::plant
