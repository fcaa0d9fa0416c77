// SPDX-License-Identifier: Apache-2.0
// Programmer errors: VOLTLAP_REQUIRE is always on and never returns when its condition is false. Operating errors
// (lost frames, cells out of range) are no programmer errors: they go to the fault table.
#pragma once

namespace voltlap {

/// Drives the safe state and never returns. base/require.cpp holds a weak default that stops the processor, so that
/// the frames of this node cease and every receiver opens or disables by timeout; a port defines its own with the
/// outputs of its board.
[[noreturn]] void require_failed(const char* condition, const char* file, int line);

}  // namespace voltlap

#define VOLTLAP_REQUIRE(condition) \
  ((condition) ? static_cast<void>(0) : ::voltlap::require_failed(#condition, __FILE__, __LINE__))
