// SPDX-License-Identifier: Apache-2.0
// What a mutated copy of the firmware includes: every change stands behind a switch, and one of them is on.
#pragma once

extern int voltlap_mutant_on;
extern unsigned char voltlap_mutants_reached[];

namespace voltlap_mutation {

// A constant expression sees no change: what is computed at compile time stays sound.
constexpr bool on(int mutant) {
  if (__builtin_is_constant_evaluated()) return false;
  voltlap_mutants_reached[mutant] = 1;
  return voltlap_mutant_on == mutant;
}

// `<` and its kin with the boundary moved, by the same operator, so that a type needs no other one.
template <class A, class B>
constexpr bool less(bool m, const A& a, const B& b) { return m ? !(b < a) : a < b; }
template <class A, class B>
constexpr bool less_equal(bool m, const A& a, const B& b) { return m ? !(b <= a) : a <= b; }
template <class A, class B>
constexpr bool more(bool m, const A& a, const B& b) { return m ? !(b > a) : a > b; }
template <class A, class B>
constexpr bool more_equal(bool m, const A& a, const B& b) { return m ? !(b >= a) : a >= b; }

#define VOLTLAP_SWAPPED(name, op, other)                              \
  template <class A, class B>                                         \
  constexpr auto name(bool m, const A& a, const B& b) -> decltype(m ? a other b : a op b) { \
    return m ? a other b : a op b;                                    \
  }                                                                   \
  template <class A, class B>                                         \
  constexpr auto name##_to(bool m, A& a, const B& b) -> decltype(m ? a other##= b : a op##= b) { \
    return m ? a other##= b : a op##= b;                              \
  }
VOLTLAP_SWAPPED(plus, +, -)
VOLTLAP_SWAPPED(minus, -, +)
VOLTLAP_SWAPPED(times, *, /)
VOLTLAP_SWAPPED(over, /, *)
VOLTLAP_SWAPPED(rest, %, *)
VOLTLAP_SWAPPED(bit_and, &, |)
VOLTLAP_SWAPPED(bit_or, |, &)
VOLTLAP_SWAPPED(left, <<, >>)
VOLTLAP_SWAPPED(right, >>, <<)

template <class A>
constexpr auto negative(bool m, const A& a) -> decltype(m ? a : -a) { return m ? a : -a; }

template <class T>
constexpr T doubled(bool m, T value, long) {
  if constexpr (__is_same(T, bool)) return m ? !value : value;
  else return m ? static_cast<T>(value == 0 ? 1 : 2 * value) : value;
}
template <class T>
constexpr auto doubled(bool m, T value, int) -> decltype(T::from_raw(value.raw())) {
  using Raw = decltype(value.raw());
  return m ? T::from_raw(static_cast<Raw>(value.raw() == 0 ? 1 : 2 * value.raw())) : value;
}

}  // namespace voltlap_mutation

#define VM(n) (::voltlap_mutation::on(n))
