# SPDX-License-Identifier: BSD-3-Clause
"""The page and the dialogue of `culm setup`."""
