// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/cloud_file.hpp"
