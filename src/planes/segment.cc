// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/segment.hpp"
