"""The errata of the paper, in words: printed, mended, what shows it, and which simulations are affected.

1 to 12 are those that controllers know by these numbers; from 13 on they were found since. A sentence of evidence has
places for the figures that its function computes.
"""

from experiments.errata import evidence, evidence_text
from experiments.errata.entry import PROOF, Entry
from experiments.errata.found import FOUND

TWO = ("figure8", "circle")
"""The cases of two robots that each erratum of the algorithm is simulated on."""
MOTION = (
    "Against the exact motion of {2:.0f} random pairs dz/dt is off by up to {0:.2g} m/s as printed, {1:.1g} mended."
)

PRINTED = (
    Entry(
        1,
        "eq. (3), rows x_e and y_e",
        "ω_c (y_e + ξ₁), ω_c (x_e − ξ₂)",
        "ω_c y_e, ω_c x_e",
        "erratum_1_omega_times_xi_does_not_belong_into_the_rows_x_and_y",
        MOTION,
        lambda: (*evidence.rate_errors(1), evidence.CASES),
        cases=("triangle-corner",),
        as_mended={"controller": {"errata": [1]}},
        note="Two robots have p_v = 0 and do not feel it.",
    ),
    Entry(
        2,
        "eq. (3), rows x_e and y_e",
        "v_c = (v_i + v_₋i)/2; no such term in row y_e",
        "(v_i cos(θ_i − θ_c) + v_₋i cos(θ_₋i − θ_c))/2 in row x_e, the same with sin in row y_e",
        "erratum_2_the_centres_velocity_depends_on_both_headings",
        MOTION,
        lambda: (*evidence.rate_errors(2), evidence.CASES),
        cases=TWO,
        as_mended={"controller": {"errata": [2]}},
    ),
    Entry(
        3,
        "appendix, column θ_e of (12), and a₅₄",
        "factors 2 in a₁₃, a₂₃, a₄₃, a₅₃; a₅₄ = −(v_i cos(ψ − θ_i) − v_₋i sin(ψ − θ_₋i))/l²",
        "factors 1; cos in both terms of a₅₄",
        "erratum_3_the_column_of_theta_e_has_a_factor_2_too_much",
        "a₄₃ is {0:.3f} times the derivative of eq. (3) by finite differences as printed, {1:.3f} times mended.",
        evidence.theta_column_ratio,
        cases=TWO,
        as_mended={"controller": {"errata": [3]}},
    ),
    Entry(
        4,
        "eqs. (4) and (5)",
        "‖u‖² is penalised; z₊ = A z + B_i u_i + B_₋i u_₋i",
        "‖u − u_r‖²; z₊ = A z + B_i u_i + B_₋i u_₋i + c with the affine term of the linearisation",
        "erratum_4_as_printed_a_formation_lags_behind_and_mended_it_does_not",
        "At z = 0 with the reference's inputs eq. (5) predicts z₊ off by {0:.2g} m after Δ_T = 0.1 s as printed, "
        "{1:.1g} mended: the formation has to lag behind its path to be pulled along.",
        evidence.missing_drift,
        cases=TWO,
        as_mended={"controller": {"errata": [4]}},
    ),
    Entry(
        5,
        "eqs. (8) to (11)",
        "K of (10) is that of the pair's joint optimum; (11) answers the received plan with it",
        "play the own part of that optimum: u_i = −R⁻¹ B_iᵀ λ along z₊ = W⁻¹(A z)",
        "erratum_5_playing_the_equilibrium_is_the_pairs_joint_optimum",
        "What is played differs from the equilibrium of (4), (5), (8), (9) by {0:.2g} (m/s or rad/s, median of random "
        "pairs) as printed, {1:.1g} mended.",
        evidence.distance_to_equilibrium,
        cases=TWO,
        as_mended={"controller": {"errata": [5]}},
    ),
    Entry(
        6,
        "second and third test",
        "p_v = [(√3/6) l_r, (√3/6) l_r, 0]",
        "p_v = [(√3/6) l_r, 0, 0]",
        "erratum_6_only_without_its_second_entry_is_p_v_the_centroid_of_all_three_pairs",
        "In a perfect triangle the pairs believe centres that are {0:.4f} m apart as printed, {1:.1g} m mended.",
        evidence_text.centres_apart,
        cases=("triangle-corner",),
        as_printed={"controller": {"misprints": [6]}},
    ),
    Entry(
        7,
        "first test",
        "q_r² = [0.1, −θ_r]",
        "q_r² = [0.1, θ_r + π]",
        "erratum_7_the_second_robots_psi_r_is_theta_r_plus_pi",
        "In perfect formation robot 2 sees ψ_e = {0:.3f} rad as printed, {1:.1g} mended; the caption of fig. 5, "
        "ψ_e,1 (= ψ_e,2), agrees with the mended one only.",
        evidence_text.angle_in_formation,
        cases=("figure8",),
        as_printed={"controller": {"misprints": [7]}},
    ),
    Entry(
        8,
        "first test",
        "θ_r(t₀) = π/6",
        "θ_r(t₀) = atan(1/2)",
        "erratum_8_the_first_path_starts_at_a_heading_of_atan_one_half",
        "Printed {0:.4f} rad; Ref. path 1 of Table 1 starts at {1:.4f} rad.",
        evidence_text.first_heading,
        note="Nobody computes with it: the reference's heading follows from the path.",
    ),
    Entry(
        9,
        "Table 1, Ref. path 4",
        "0.01 (cos(t/10), sin(t/10)), 'spiral'",
        "0.01 t (cos(t/10), sin(t/10))",
        "erratum_9_path_4_as_printed_is_a_circle_of_a_centimetre",
        "In 126 s the path goes {0:.2f} m from the origin as printed, {1:.2f} m mended.",
        evidence_text.fourth_path,
        cases=("spiral",),
        as_printed={"path": {"kind": "circle", "radius": 0.01, "rate": 0.1}},
    ),
    Entry(
        10,
        "third test",
        "Q = diag[0.1, 0.1, 0.2, 0.01]",
        "Q = diag[0.1, 0.1, 0.1, 0.2, 0.01], as in the second test",
        "the_weights_are_those_of_the_tests_and_erratum_10_gives_the_third_the_second_tests_q",
        "Q has {0:.0f} entries as printed, and the error state has {1:.0f}.",
        evidence_text.weights_of_the_third_test,
        note="As printed nobody can compute with it; the third test's page simulates the ways to fill it up.",
    ),
    Entry(
        11,
        "leader-follower law",
        "ω_f = ω_l + k_θ e_θ + v_l e_y sin(e_θ)/e_y",
        "ω_f = ω_l + k_θ e_θ + v_l e_y sin(e_θ)/e_θ",
        "erratum_11_with_e_theta_below_the_followers_errors_shrink",
        "With V = |e|²/2 and e = (0, 0.1 m, 0.01 rad), dV/dt is {0:+.1e} as printed, and {1:+.1e} mended.",
        evidence_text.lyapunov_slope,
        cases=(
            "figure8, leader-follower",
            "circle, leader-follower",
        ),
        as_printed={"controller": {"misprints": [11]}},
    ),
    Entry(
        12,
        "theorem 1",
        "a product of PSD matrices is PSD, hence W is positive definite and invertible",
        "W = I + S K with S, K PSD has eigenvalues ≥ 1, hence is invertible; positive definite it need not be",
        "erratum_12_a_product_of_psd_matrices_need_not_be_psd",
        "Two PSD matrices with vᵀSKv = {0:.0f}; the least vᵀWv/vᵀv is {1:.2f}, W's least eigenvalue {2:.2f}.",
        evidence_text.product_of_two,
        note=PROOF,
    ),
    Entry(
        13,
        "leader-follower law",
        "v_l, θ_l: the leader's own velocity and heading",
        "those of the follower's place, which turns with the leader: (v_l − ω_l y, ω_l x) for a place at (x, y)",
        "erratum_13_the_followers_place_turns_with_its_leader",
        "In place beside a leader on the circle of Ref. path 2 the follower leaves its place at {0:.2g} m/s by the "
        "printed law, {1:.1g} by the mended one: the baseline's errors are this term, not the nonholonomic constraint.",
        evidence_text.leaving_the_place,
        cases=(
            "figure8, leader-follower",
            "circle, leader-follower",
        ),
        as_mended={"controller": {"errata": [13]}},
    ),
    Entry(
        14,
        "eqs. (10) and (11)",
        "(10) counts both players' inputs, (11) the own one, given the received plan",
        "a best response to a received plan: (10) with B_i alone, and an affine costate for B_₋i u_₋i",
        "erratum_14_eq_11_is_no_best_response_to_the_received_plan_either",
        "What is played differs from the best response to the received plan by {0:.2g} (median of random pairs) as "
        "printed, {1:.1g} mended.",
        evidence.distance_to_best_response,
        cases=TWO,
        as_mended={"controller": {"errata": [14]}},
    ),
)

ENTRIES = (*PRINTED, *FOUND)
