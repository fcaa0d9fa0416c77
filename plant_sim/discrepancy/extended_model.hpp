// SPDX-License-Identifier: Apache-2.0
// The model with its causes as a file of the kind that was given, which every command takes.
#pragma once
#include <string>

#include "discrepancy/model.hpp"

namespace voltlap::plant {

/// TOML of the model at `model.path` with what `extended` changes; empty when nothing of the plant changes (a cause
/// in a sensor). A vehicle is written as one built on the given file.
[[nodiscard]] std::string extended_model_toml(const Model& model, const World& extended, const std::string& why);

}  // namespace voltlap::plant
