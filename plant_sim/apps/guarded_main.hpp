// SPDX-License-Identifier: Apache-2.0
// What every program of the project does around its work: errors become one message on standard error and an exit code.
#pragma once

namespace voltlap::plant {

/// Runs `program` and returns its exit code, or that of the error it threw. A full disk, a file limit or a reader of
/// standard output that went away is an error like any other, not a sudden end.
int guarded_main(int (*program)(int, char**), int argc, char** argv);

}  // namespace voltlap::plant
