// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>

#define printk std::printf
