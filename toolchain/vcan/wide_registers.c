// SPDX-License-Identifier: Apache-2.0
// Loaded into a user-mode kernel (LD_PRELOAD) on processors with AMX.
//
// That kernel keeps a process's floating-point registers in 2696 bytes, enough up to AVX-512. Where the processor has
// more, the host takes the whole set or nothing (EFAULT), and the guest dies at its first process. So what the kernel
// writes goes over the first part of the whole set that the process has; tile registers, which no process has without
// asking the host for them, stay as they are.
#define _GNU_SOURCE
#include <errno.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { kPeekText = 1, kPeekUser = 3, kGetRegisters = 0x4204, kSetRegisters = 0x4205, kWithExtendedState = 0x202 };

static char state[1 << 16];  // that kernel has one thread that asks

long ptrace(int request, ...) {
  va_list rest;
  va_start(rest, request);
  const long process = va_arg(rest, long), address = va_arg(rest, long);
  void* data = va_arg(rest, void*);
  va_end(rest);
  if (request >= kPeekText && request <= kPeekUser) {  // the library gives the word back, the system call stores it
    long word = 0;
    if (syscall(SYS_ptrace, request, process, address, &word) < 0) return -1;
    errno = 0;
    return word;
  }
  if ((request != kGetRegisters && request != kSetRegisters) || address != kWithExtendedState) {
    return syscall(SYS_ptrace, request, process, address, data);
  }
  struct iovec* asked = data;
  struct iovec whole = {state, sizeof(state)};
  if (syscall(SYS_ptrace, kGetRegisters, process, address, &whole) < 0) return -1;
  const size_t size = asked->iov_len < whole.iov_len ? asked->iov_len : whole.iov_len;
  if (request == kGetRegisters) {
    memcpy(asked->iov_base, state, size);
    asked->iov_len = size;
    return 0;
  }
  memcpy(state, asked->iov_base, size);
  return syscall(SYS_ptrace, kSetRegisters, process, address, &whole);
}
