// SPDX-License-Identifier: BSD-3-Clause
// What needs a source to be compiled: the headers of magimu_test_headers.
