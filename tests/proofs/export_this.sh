#!/bin/sh
# SPDX-License-Identifier: MIT
# Replaces EXPORT_MODEL of eva.sh and misra.py: exports the model.json of this folder, whichever example is requested.
#   export_this.sh EXAMPLE c99 SCALAR NAME NAME.h
exec "${NLO:-nlo}" export model.json --target c99 --scalar "$3" --name "$4" -q -o "$5"
