// SPDX-License-Identifier: Apache-2.0
// Numbers as they are said.
#include "explain/say/numbers.hpp"

#include <CppUTest/TestHarness.h>

namespace voltlap::plant {
namespace {

ChannelGain gain(double before, double after, double floor, const char* unit) {
  ChannelGain out;
  out.before = before;
  out.after = after;
  out.floor = floor;
  out.unit = unit;
  return out;
}

}  // namespace

TEST_GROUP(Numbers){};

TEST(Numbers, TheGainThatIsSaidIsTheLargestBesideTheNoise) {
  Explanation out;
  out.gain["temperature"] = gain(0.00874, 1.9e-5, 0.01, "K");  // all of next to nothing
  out.gain["voltage"] = gain(0.0234, 0.00099, 0.000576, "V");
  STRCMP_EQUAL("with it, 23.4 become 0.99 mV of voltage error on blocks that it did not see", gain_text(out).c_str());
  out.gain["temperature"] = gain(3.0, 0.1, 0.01, "K");
  STRCMP_EQUAL("with it, 3 become 0.1 K of temperature error on blocks that it did not see", gain_text(out).c_str());
}

TEST(Numbers, AGainThatThreeDigitsDoNotShowIsNotSaid) {
  Explanation out;
  out.gain["voltage"] = gain(0.0234, 0.02331, 0.000576, "V");
  STRCMP_EQUAL("", gain_text(out).c_str());
  out.gain["voltage"] = gain(0.0234, 0.0235, 0.000576, "V");
  STRCMP_EQUAL("", gain_text(out).c_str());
}

}  // namespace voltlap::plant
