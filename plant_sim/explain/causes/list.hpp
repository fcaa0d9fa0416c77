// SPDX-License-Identifier: Apache-2.0
// The catalogue: every cause that regression can name. A new one is a file of this folder that defines the function
// of its name; names.hpp is made from the files.
#pragma once
#include <vector>

#include "explain/causes/cause.hpp"
#include "explain/causes/names.hpp"

namespace voltlap::plant {

#define VOLTLAP_DECLARE(name) [[nodiscard]] Cause name();
VOLTLAP_CAUSES(VOLTLAP_DECLARE)
#undef VOLTLAP_DECLARE

/// All causes by balance and name, without those named in `without`. Throws InputError for a name that is none.
[[nodiscard]] std::vector<Cause> catalogue(const std::vector<std::string>& without);

/// Typical sizes for this cell: those of resistances grow with its own.
void size_for(const CellParameters& cell, std::vector<Cause>& causes);

}  // namespace voltlap::plant
