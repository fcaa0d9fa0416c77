// SPDX-License-Identifier: Apache-2.0
// Frames and signals of a DBC file (or KCD, SYM, ARXML) as JSON. cantools, the field's own parser, reads the file
// (plant_sim/python/voltlap_logs/dbc_json.py); what it gave stands in $XDG_CACHE_HOME/voltlap/dbc, else in
// ~/.cache/voltlap/dbc, under a name made of the file's content, so that a file is parsed once.
#pragma once
#include <string>

namespace voltlap::plant {

/// Throws InputError for a file that is none of these, and where there is neither a cache entry nor a Python with
/// cantools.
[[nodiscard]] std::string dbc_json(const std::string& path);

}  // namespace voltlap::plant
