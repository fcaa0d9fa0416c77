// SPDX-License-Identifier: Apache-2.0
// The configuration of a run, drawn: mostly what the firmware has by itself, some of it changed, sometimes refused.
#pragma once
#include <cstdint>
#include <vector>

#include "draw.hpp"
#include "node_api.hpp"

namespace same_firmware {

[[nodiscard]] Settings draw_settings(Draw& draw);

struct NamedSetting {
  const char* name;
  std::int32_t* value;
};
/// Every setting, by the name of its field.
[[nodiscard]] std::vector<NamedSetting> settings_by_name(Settings& settings);

}  // namespace same_firmware
