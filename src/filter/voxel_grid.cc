// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/voxel_grid.hpp"
