#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Compares the explicit step with that of LIGGGHTS with flexible fibres, in turn on this machine.
#
#   bench/peer_step.sh LIGGGHTS BUILD [ROUNDS]
#
# LIGGGHTS is the program; BUILD the folder with bench/bench_explicit_step. Each round measures the
# peer's "Loop time" for 56 spheres and 55 bonds, without output, and then culm against it.
set -euo pipefail
if (($# < 2 || $# > 3)); then
    echo "use: bench/peer_step.sh LIGGGHTS BUILD [ROUNDS]" >&2
    exit 2
fi
peer=$(realpath "$1")
culm=$(realpath "$2")/bench/bench_explicit_step
rounds=${3:-3}
steps=100000
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/in.chain" <<END
units si
atom_style hybrid granular bond/gran n_bondtypes 1 bonds_per_atom 6
atom_modify map array
hard_particles yes
boundary f f f
newton off
communicate single vel yes
region box block -0.01 0.17 -0.02 0.02 -0.02 0.02 units box
create_box 1 box
lattice sc 2.83e-3
region line cylinder x 0 0 1e-3 -1e-4 0.1558 units box
create_atoms 1 region line
pair_style gran model hertz tangential history
pair_coeff * *
bond_style gran
bond_coeff 1 1 0 1e9 3.846153846e8 1 25 1 1e32 1e32
neighbor 1e-3 bin
fix 1 all property/global youngsModulus peratomtype 4.4e9
fix 2 all property/global poissonsRatio peratomtype 0.3
fix 3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix 4 all property/global coefficientFriction peratomtypepair 1 0.001
run 0
set type 1 diameter 2.83e-3 density 125
group clamp id 1
group tip id 56
fix bonds all bond/create/gran 1 1 1 2.9e-3 1 6
timestep 1e-8
fix step all nve/sphere
run 1
fix_modify bonds every 0
fix clamp clamp freeze
velocity tip set 0 0 1 units box
thermo_style custom step atoms numbonds
thermo $steps
run $steps
END
# Median per stem of a variant, from the table of bench_explicit_step.
median_of() { awk -F '|' -v name="$1" '$2 ~ name {print $6 + 0}' "$folder/culm"; }

printf '| round | peer, ns | planar, scalar | planar, lanes | spatial, scalar | spatial, lanes '
printf '| times faster in space |\n|---:|---:|---:|---:|---:|---:|---:|\n'
for ((round = 1; round <= rounds; ++round)); do
    (cd "$folder" && "$peer" -in in.chain -log log.chain >/dev/null)
    read -r atoms bonds < <(awk -v step=$((steps + 1)) '$1 == step && NF == 3 {print $2, $3}' \
        "$folder/log.chain" | tail -1)
    if [[ $atoms != 56 || $bonds != 55 ]]; then
        echo "peer_step.sh: the peer has $atoms spheres and $bonds bonds, not 56 and 55" >&2
        exit 1
    fi
    peer_ns=$(awk -v steps=$steps '/^Loop time of/ {seconds = $4}
        END {printf "%.1f", 1e9 * seconds / steps / 55}' "$folder/log.chain")
    "$culm" >"$folder/culm"
    awk -v round="$round" -v peer="$peer_ns" -v ps="$(median_of 'planar, scalar')" \
        -v pl="$(median_of 'planar, lanes')" -v ss="$(median_of 'spatial, scalar')" \
        -v sl="$(median_of 'spatial, lanes')" 'BEGIN {
            printf "| %d | %s | %s | %s | %s | %s | %.1f |\n", round, peer, ps, pl, ss, sl, peer / sl }'
done
