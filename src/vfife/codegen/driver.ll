; What drives a straight-line step of WIDTH lanes, and the functions of time that it asks for.

; advance(S, T, stride, n0, count, outputs, out, kept, keeping, extremes, resetting): outputs times count steps from step n0.
; T holds the tables of all lanes, stride apart. Before each count the rows in extremes start anew, after it the rows in kept are copied to
; out, of shape (outputs, keeping, WIDTH). The whole step starts a run and takes every step that the lean one leaves.
define void @advance(ptr noalias %S, ptr noalias %T, i64 %stride, i64 %n0, i64 %count, i64 %outputs, ptr noalias %out, ptr noalias %kept, i64 %keeping, ptr noalias %extremes, i64 %resetting) {
entry:
  br label %output
output:
  %m = phi i64 [ 0, %entry ], [ %m.next, %copied ]
  %unfinished = icmp slt i64 %m, %outputs
  br i1 %unfinished, label %reset, label %finished
reset:
  %q = phi i64 [ 0, %output ], [ %q.next, %anew ]
  %resets = icmp slt i64 %q, %resetting
  br i1 %resets, label %anew, label %begin
anew:
  %extreme.at = getelementptr i32, ptr %extremes, i64 %q
  %extreme.row = load i32, ptr %extreme.at, align 4
  %extreme = zext i32 %extreme.row to i64
  %extreme.first = mul i64 %extreme, WIDTH
  %extreme.place = getelementptr double, ptr %S, i64 %extreme.first
  store NUMBER zeroinitializer, ptr %extreme.place, align 8
  %q.next = add i64 %q, 1
  br label %reset
begin:
  %before = mul i64 %m, %count
  %from = add i64 %n0, %before
  %to = add i64 %from, %count
  br label %steps
steps:
  %n = phi i64 [ %from, %begin ], [ %n.next, %one ]
  %left = sub i64 %to, %n
  %any = icmp sgt i64 %left, 0
  br i1 %any, label %chosen, label %copy
chosen:
  %start = icmp eq i64 %n, 0
  br i1 %start, label %one, label %many
many:
  %clean = call i64 @lean(ptr %S, ptr %T, i64 %stride, i64 %n, i64 %left)
  %n.clean = add i64 %n, %clean
  %stopped = icmp slt i64 %n.clean, %to
  br i1 %stopped, label %one, label %copy
one:
  %n.one = phi i64 [ %n, %chosen ], [ %n.clean, %many ]
  call void @whole(ptr %S, ptr %T, i64 %stride, i64 %n.one)
  %n.next = add i64 %n.one, 1
  br label %steps
copy:
  %row0 = mul i64 %m, %keeping
  br label %copies
copies:
  %k = phi i64 [ 0, %copy ], [ %k.next, %keep ]
  %keeps = icmp slt i64 %k, %keeping
  br i1 %keeps, label %keep, label %copied
keep:
  %kept.at = getelementptr i32, ptr %kept, i64 %k
  %kept.row = load i32, ptr %kept.at, align 4
  %row = zext i32 %kept.row to i64
  %row.first = mul i64 %row, WIDTH
  %row.place = getelementptr double, ptr %S, i64 %row.first
  %value = load NUMBER, ptr %row.place, align 8
  %out.row = add i64 %row0, %k
  %out.first = mul i64 %out.row, WIDTH
  %out.place = getelementptr double, ptr %out, i64 %out.first
  store NUMBER %value, ptr %out.place, align 8
  %k.next = add i64 %k, 1
  br label %copies
copied:
  %m.next = add i64 %m, 1
  br label %output
finished:
  ret void
}

; polynomial(T, start, time): value and two derivatives of a table, as kernels/polynomial.py has them.
define internal { double, double, double } @polynomial(ptr %T, i64 %start, double %time) noinline {
entry:
  %head = getelementptr double, ptr %T, i64 %start
  %head.value = load double, ptr %head, align 8
  %number = fptosi double %head.value to i64
  %after.head = add i64 %start, 1
  %repeats = icmp slt i64 %number, 0
  br i1 %repeats, label %fold, label %found
fold:
  %positive = sub i64 0, %number
  %period.at = getelementptr double, ptr %T, i64 %after.head
  %period = load double, ptr %period.at, align 8
  %after.period = add i64 %after.head, 1
  %turns = fdiv double %time, %period
  %turns.less = fsub double %turns, 0x3FE0000000000000
  %turns.big = fadd double %turns.less, 0x4338000000000000
  %turns.whole = fsub double %turns.big, 0x4338000000000000
  %past = fmul double %turns.whole, %period
  %folded = fsub double %time, %past
  br label %found
found:
  %pieces = phi i64 [ %number, %entry ], [ %positive, %fold ]
  %first = phi i64 [ %after.head, %entry ], [ %after.period, %fold ]
  %t = phi double [ %time, %entry ], [ %folded, %fold ]
  %top = sub i64 %pieces, 1
  br label %search
search:
  %low = phi i64 [ 0, %found ], [ %low.next, %halve ]
  %high = phi i64 [ %top, %found ], [ %high.next, %halve ]
  %more = icmp slt i64 %low, %high
  br i1 %more, label %halve, label %sum
halve:
  %sum.both = add i64 %low, %high
  %sum.up = add i64 %sum.both, 1
  %middle = lshr i64 %sum.up, 1
  %middle.index = add i64 %first, %middle
  %middle.at = getelementptr double, ptr %T, i64 %middle.index
  %middle.time = load double, ptr %middle.at, align 8
  %begun = fcmp ole double %middle.time, %t
  %below = sub i64 %middle, 1
  %low.next = select i1 %begun, i64 %middle, i64 %low
  %high.next = select i1 %begun, i64 %high, i64 %below
  br label %search
sum:
  %begin.index = add i64 %first, %low
  %begin.at = getelementptr double, ptr %T, i64 %begin.index
  %begin = load double, ptr %begin.at, align 8
  %x = fsub double %t, %begin
  %coefficients = add i64 %first, %pieces
  %skip = mul i64 %low, 7
  %c = add i64 %coefficients, %skip
  br label %horner
horner:
  %k = phi i64 [ 6, %sum ], [ %k.next, %horner ]
  %value = phi double [ 0.0, %sum ], [ %value.next, %horner ]
  %rate = phi double [ 0.0, %sum ], [ %rate.next, %horner ]
  %half = phi double [ 0.0, %sum ], [ %half.next, %horner ]
  %half.x = fmul double %half, %x
  %half.next = fadd double %half.x, %rate
  %rate.x = fmul double %rate, %x
  %rate.next = fadd double %rate.x, %value
  %index = add i64 %c, %k
  %at = getelementptr double, ptr %T, i64 %index
  %coefficient = load double, ptr %at, align 8
  %value.x = fmul double %value, %x
  %value.next = fadd double %value.x, %coefficient
  %k.next = sub i64 %k, 1
  %again = icmp sge i64 %k.next, 0
  br i1 %again, label %horner, label %end
end:
  %second = fmul double 0x4000000000000000, %half.next
  %result.0 = insertvalue { double, double, double } poison, double %value.next, 0
  %result.1 = insertvalue { double, double, double } %result.0, double %rate.next, 1
  %result.2 = insertvalue { double, double, double } %result.1, double %second, 2
  ret { double, double, double } %result.2
}
