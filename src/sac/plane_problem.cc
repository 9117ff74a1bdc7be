// SPDX-License-Identifier: Apache-2.0
#include "fransac/sac/plane_problem.hpp"
