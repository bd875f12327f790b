// SPDX-License-Identifier: Zlib
#include "clod/bullet/Abi.h"

int CLOD_ABI_SYMBOL = 1;
