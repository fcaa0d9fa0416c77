// SPDX-License-Identifier: Apache-2.0
#include "base/require.hpp"

namespace voltlap {

__attribute__((weak)) void require_failed(const char* /*condition*/, const char* /*file*/, int /*line*/) {
  __builtin_trap();
}

}  // namespace voltlap
