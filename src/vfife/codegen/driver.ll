; advance(S, Q, T, stride, n0, count, outputs, parts, shares, out, kept, keeping, extremes, resetting, look, finite, limited, limiting, limits, broken):
; outputs times count steps from step n0.
; T holds the tables of all lanes, stride apart. Before each count the rows in extremes start anew, after it the rows in kept are copied to
; out, of shape (outputs, keeping, WIDTH). The whole step starts a run and takes every step that the lean one leaves; a lane in which something
; began, ended or changed its regime then takes that step again in so many parts. The first step of a lane is a share of one, where that is not
; zero, beside those that are counted. Q is room for two more copies of the state. Wherever look divides the number of steps made, lanes are
; watched; when
; the last of those that are looked at has broken, it is over, and rows of out that are left are as they were.
define void @advance(ptr noalias %S, ptr noalias %Q, ptr noalias %T, i64 %stride, i64 %n0, i64 %count, i64 %outputs, i64 %parts, ptr noalias %shares, ptr noalias %out, ptr noalias %kept, i64 %keeping, ptr noalias %extremes, i64 %resetting, i64 %look, i64 %finite, ptr noalias %limited, i64 %limiting, ptr noalias %limits, ptr noalias %broken) ENTERED {
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
  %n = phi i64 [ %from, %begin ], [ %n.made, %made ], [ %n.made, %watched ]
  %left = sub i64 %to, %n
  %any = icmp sgt i64 %left, 0
  br i1 %any, label %chosen, label %copy
chosen:
  %start = icmp eq i64 %n, 0
  br i1 %start, label %first, label %many
many:
  %unseen = urem i64 %n, %look
  %until = sub i64 %look, %unseen
  %sooner = icmp slt i64 %until, %left
  %piece = select i1 %sooner, i64 %until, i64 %left
  %end = add i64 %n, %piece
  %clean = call i64 @lean(ptr %S, ptr %Q, ptr %T, i64 %stride, i64 %n, i64 %piece)
  %n.clean = add i64 %n, %clean
  %stopped = icmp slt i64 %n.clean, %end
  br i1 %stopped, label %eventful, label %made
first:
  call void @whole(ptr %S, ptr %T, i64 %stride, i64 %n)
  br label %one
eventful:
  call void @event(ptr %S, ptr %Q, ptr %T, i64 %stride, i64 %n.clean, i64 %parts)
  br label %one
one:
  %n.one = phi i64 [ %n, %first ], [ %n.clean, %eventful ]
  %n.next = add i64 %n.one, 1
  br i1 %start, label %displaced, label %made
displaced:
  call void @displace(ptr %S, ptr %Q, ptr %T, i64 %stride, ptr %shares)
  br label %made
made:
  %n.made = phi i64 [ %n.clean, %many ], [ %n.next, %one ], [ %n.next, %displaced ]
  %since = urem i64 %n.made, %look
  %due = icmp eq i64 %since, 0
  br i1 %due, label %watched, label %steps
watched:
  %on = call i1 @watch(ptr %S, ptr %kept, i64 %finite, ptr %limited, i64 %limiting, ptr %limits, ptr %broken, i64 %n.made)
  br i1 %on, label %steps, label %finished
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

; stream(S, Q, T, stride, n0, count, parts, kept, keeping, extremes, resetting, look, sound, finite, limited, limiting, limits, broken, due, every, at, stop, room, out):
; up to count steps from step n0, not 0; each lane hands out rows of its own time. After due[w] steps the rows in kept of lane w are copied to
; out, of shape (lanes, room, keeping), as its output at[w]; its extremes start anew, and it is due again every[w] steps later. When a lane that
; at[w] has brought to stop[w], or one that broke, it is over; the number of steps made is returned.
define i64 @stream(ptr noalias %S, ptr noalias %Q, ptr noalias %T, i64 %stride, i64 %n0, i64 %count, i64 %parts, ptr noalias %kept, i64 %keeping, ptr noalias %extremes, i64 %resetting, i64 %look, ptr noalias %sound, i64 %finite, ptr noalias %limited, i64 %limiting, ptr noalias %limits, ptr noalias %broken, ptr noalias %due, ptr noalias %every, ptr noalias %at, ptr noalias %stop, i64 %room, ptr noalias %out) ENTERED {
entry:
  %last = add i64 %n0, %count
  br label %sooner
sooner:
  %from = phi i64 [ %n0, %entry ], [ %n, %handed ]
  br label %lane
lane:
  %w = phi i64 [ 0, %sooner ], [ %w.next, %lane ]
  %soonest = phi i64 [ %last, %sooner ], [ %soonest.next, %lane ]
  %due.at = getelementptr i64, ptr %due, i64 %w
  %due.here = load i64, ptr %due.at, align 8
  %before = icmp slt i64 %due.here, %soonest
  %soonest.next = select i1 %before, i64 %due.here, i64 %soonest
  %w.next = add i64 %w, 1
  %lanes = icmp slt i64 %w.next, LANES
  br i1 %lanes, label %lane, label %steps
steps:
  %n = phi i64 [ %from, %lane ], [ %n.made, %made ], [ %n.made, %watched ]
  %left = sub i64 %soonest.next, %n
  %any = icmp sgt i64 %left, 0
  br i1 %any, label %many, label %hand
many:
  %unseen = urem i64 %n, %look
  %until = sub i64 %look, %unseen
  %seen = icmp slt i64 %until, %left
  %piece = select i1 %seen, i64 %until, i64 %left
  %end = add i64 %n, %piece
  %clean = call i64 @lean(ptr %S, ptr %Q, ptr %T, i64 %stride, i64 %n, i64 %piece)
  %n.clean = add i64 %n, %clean
  %stopped = icmp slt i64 %n.clean, %end
  br i1 %stopped, label %eventful, label %made
eventful:
  call void @event(ptr %S, ptr %Q, ptr %T, i64 %stride, i64 %n.clean, i64 %parts)
  %n.event = add i64 %n.clean, 1
  br label %made
made:
  %n.made = phi i64 [ %n.clean, %many ], [ %n.event, %eventful ]
  %since = urem i64 %n.made, %look
  %look.due = icmp eq i64 %since, 0
  br i1 %look.due, label %watched, label %steps
watched:
  %on = call i1 @watch(ptr %S, ptr %sound, i64 %finite, ptr %limited, i64 %limiting, ptr %limits, ptr %broken, i64 %n.made)
  %broken.lanes = load NUMBER, ptr %broken, align 8
  %gone = fcmp ogt NUMBER %broken.lanes, zeroinitializer
  %some = call i1 @any(TRUTH %gone)
  br i1 %some, label %over, label %steps
hand:
  br label %next
next:
  %v = phi i64 [ 0, %hand ], [ %v.next, %after ]
  %ended = phi i1 [ false, %hand ], [ %ended.next, %after ]
  %more = icmp slt i64 %v, LANES
  br i1 %more, label %look.at, label %handed
look.at:
  %v.due.at = getelementptr i64, ptr %due, i64 %v
  %v.due = load i64, ptr %v.due.at, align 8
  %is.due = icmp eq i64 %v.due, %n
  br i1 %is.due, label %copy, label %after
copy:
  %v.at.at = getelementptr i64, ptr %at, i64 %v
  %v.at = load i64, ptr %v.at.at, align 8
  %v.room = mul i64 %v, %room
  %v.place = add i64 %v.room, %v.at
  %v.first = mul i64 %v.place, %keeping
  br label %copies
copies:
  %k = phi i64 [ 0, %copy ], [ %k.next, %keep ]
  %keeps = icmp slt i64 %k, %keeping
  br i1 %keeps, label %keep, label %resets
keep:
  %kept.at = getelementptr i32, ptr %kept, i64 %k
  %kept.row = load i32, ptr %kept.at, align 4
  %row = zext i32 %kept.row to i64
  %row.first = mul i64 %row, WIDTH
  %row.lane = add i64 %row.first, %v
  %row.place = getelementptr double, ptr %S, i64 %row.lane
  %value = load double, ptr %row.place, align 8
  %out.row = add i64 %v.first, %k
  %out.place = getelementptr double, ptr %out, i64 %out.row
  store double %value, ptr %out.place, align 8
  %k.next = add i64 %k, 1
  br label %copies
resets:
  %q = phi i64 [ 0, %copies ], [ %q.next, %anew ]
  %resets.more = icmp slt i64 %q, %resetting
  br i1 %resets.more, label %anew, label %told
anew:
  %extreme.at = getelementptr i32, ptr %extremes, i64 %q
  %extreme.row = load i32, ptr %extreme.at, align 4
  %extreme = zext i32 %extreme.row to i64
  %extreme.first = mul i64 %extreme, WIDTH
  %extreme.lane = add i64 %extreme.first, %v
  %extreme.place = getelementptr double, ptr %S, i64 %extreme.lane
  store double 0.0, ptr %extreme.place, align 8
  %q.next = add i64 %q, 1
  br label %resets
told:
  %v.at.next = add i64 %v.at, 1
  store i64 %v.at.next, ptr %v.at.at, align 8
  %v.every.at = getelementptr i64, ptr %every, i64 %v
  %v.every = load i64, ptr %v.every.at, align 8
  %v.due.next = add i64 %v.due, %v.every
  store i64 %v.due.next, ptr %v.due.at, align 8
  %v.stop.at = getelementptr i64, ptr %stop, i64 %v
  %v.stop = load i64, ptr %v.stop.at, align 8
  %full = icmp sge i64 %v.at.next, %v.stop
  br label %after
after:
  %full.here = phi i1 [ false, %look.at ], [ %full, %told ]
  %ended.next = or i1 %ended, %full.here
  %v.next = add i64 %v, 1
  br label %next
handed:
  %spent = icmp sge i64 %n, %last
  %enough = or i1 %ended, %spent
  br i1 %enough, label %over, label %sooner
over:
  %made.in.all = phi i64 [ %n, %handed ], [ %n.made, %watched ]
  ret i64 %made.in.all
}

; watch(S, kept, finite, limited, limiting, limits, broken, n): a lane with a number among the rows kept that is not finite, or one in a row of
; limited that is not between the two of limits, breaks after n steps; a lane that is not at zero in broken has done so, or is not looked at.
; Whether there is still a lane at zero.
define internal i1 @watch(ptr noalias %S, ptr noalias %kept, i64 %finite, ptr noalias %limited, i64 %limiting, ptr noalias %limits, ptr noalias %broken, i64 %n) noinline {
entry:
  br label %row
row:
  %k = phi i64 [ 0, %entry ], [ %k.next, %sum ]
  %nothing = phi NUMBER [ zeroinitializer, %entry ], [ %nothing.next, %sum ]
  %more = icmp slt i64 %k, %finite
  br i1 %more, label %sum, label %summed
sum:
  %kept.at = getelementptr i32, ptr %kept, i64 %k
  %kept.row = load i32, ptr %kept.at, align 4
  %kept.long = zext i32 %kept.row to i64
  %kept.first = mul i64 %kept.long, WIDTH
  %kept.place = getelementptr double, ptr %S, i64 %kept.first
  %kept.value = load NUMBER, ptr %kept.place, align 8
  %zero = fmul NUMBER %kept.value, zeroinitializer
  %nothing.next = fadd NUMBER %nothing, %zero
  %k.next = add i64 %k, 1
  br label %row
summed:
  %infinite = fcmp uno NUMBER %nothing, zeroinitializer
  br label %limit
limit:
  %q = phi i64 [ 0, %summed ], [ %q.next, %compare ]
  %bad = phi TRUTH [ %infinite, %summed ], [ %bad.next, %compare ]
  %some = icmp slt i64 %q, %limiting
  br i1 %some, label %compare, label %noted
compare:
  %limited.at = getelementptr i32, ptr %limited, i64 %q
  %limited.row = load i32, ptr %limited.at, align 4
  %limited.long = zext i32 %limited.row to i64
  %limited.first = mul i64 %limited.long, WIDTH
  %limited.place = getelementptr double, ptr %S, i64 %limited.first
  %value = load NUMBER, ptr %limited.place, align 8
  %two = mul i64 %q, 2
  %low.first = mul i64 %two, WIDTH
  %high.first = add i64 %low.first, WIDTH
  %low.place = getelementptr double, ptr %limits, i64 %low.first
  %high.place = getelementptr double, ptr %limits, i64 %high.first
  %low = load NUMBER, ptr %low.place, align 8
  %high = load NUMBER, ptr %high.place, align 8
  %below = fcmp ult NUMBER %value, %low
  %above = fcmp ugt NUMBER %value, %high
  %beyond = or TRUTH %below, %above
  %bad.next = or TRUTH %bad, %beyond
  %q.next = add i64 %q, 1
  br label %limit
noted:
  %before = load NUMBER, ptr %broken, align 8
  %whole.before = fcmp oeq NUMBER %before, zeroinitializer
  %breaks = and TRUTH %bad, %whole.before
  %number = sitofp i64 %n to double
  %here = call NUMBER @all(double %number)
  %after = select TRUTH %breaks, NUMBER %here, NUMBER %before
  store NUMBER %after, ptr %broken, align 8
  %whole.after = fcmp oeq NUMBER %after, zeroinitializer
  %left = call i1 @any(TRUTH %whole.after)
  ret i1 %left
}

; event(S, Q, T, stride, n, parts): step n as a whole; lanes in which something began, ended or changed its regime take it again in parts, lean
; ones where nothing rare wants another. Behind Q there is room for one more copy of the state.
define internal void @event(ptr noalias %S, ptr noalias %Q, ptr noalias %T, i64 %stride, i64 %n, i64 %parts) noinline {
entry:
  call void @keep(ptr %Q, ptr %S)
  call void @whole(ptr %S, ptr %T, i64 %stride, i64 %n)
  %several = icmp sgt i64 %parts, 1
  br i1 %several, label %look, label %done
look:
  %event.at = getelementptr double, ptr %S, i64 EVENT_ROW
  %event = load NUMBER, ptr %event.at, align 8
  %again = fcmp ogt NUMBER %event, zeroinitializer
  %any = call i1 @any(TRUTH %again)
  br i1 %any, label %take, label %done
take:
  %step.at = getelementptr double, ptr %S, i64 STEP_ROW
  %shift.at = getelementptr double, ptr %S, i64 SHIFT_ROW
  %dt = load NUMBER, ptr %step.at, align 8
  %shift = load NUMBER, ptr %shift.at, align 8
  %pieces.one = sitofp i64 %parts to double
  %pieces = call NUMBER @all(double %pieces.one)
  %size = fdiv NUMBER %dt, %pieces
  %ahead = fmul NUMBER %shift, %pieces
  %once = call NUMBER @all(double 1.0)
  %behind = sub i64 %n, 1
  call void @functions(ptr %Q, ptr %Q, ptr %T, i64 %stride, i64 %behind)
  call void @resize(ptr %Q, NUMBER %size, NUMBER %ahead, NUMBER %once)
  %first = mul i64 %behind, %parts
  %over = add i64 %first, %parts
  %R = getelementptr double, ptr %Q, i64 SPARE
  br label %small
small:
  %i = phi i64 [ %first, %take ], [ %i.clean, %several.small ], [ %i.whole, %rare.small ]
  %left = sub i64 %over, %i
  %more = icmp sgt i64 %left, 0
  br i1 %more, label %several.small, label %back
several.small:
  %i.next = add i64 %i, 1
  %made = call i64 @lean(ptr %Q, ptr %R, ptr %T, i64 %stride, i64 %i.next, i64 %left)
  %i.clean = add i64 %i, %made
  %rare = icmp slt i64 %i.clean, %over
  br i1 %rare, label %rare.small, label %small
rare.small:
  %i.whole = add i64 %i.clean, 1
  call void @whole(ptr %Q, ptr %T, i64 %stride, i64 %i.whole)
  br label %small
back:
  call void @resize(ptr %Q, NUMBER %dt, NUMBER %shift, NUMBER zeroinitializer)
  call void @take(ptr %S, ptr %Q, TRUTH %again)
  br label %done
done:
  ret void
}

; displace(S, Q, T, stride, shares): after the start, a first step of a share of one in lanes where that is not zero.
define internal void @displace(ptr noalias %S, ptr noalias %Q, ptr noalias %T, i64 %stride, ptr noalias %shares) noinline {
entry:
  %share = load NUMBER, ptr %shares, align 8
  %moved = fcmp ogt NUMBER %share, zeroinitializer
  %any = call i1 @any(TRUTH %moved)
  br i1 %any, label %take, label %done
take:
  call void @keep(ptr %Q, ptr %S)
  %step.at = getelementptr double, ptr %S, i64 STEP_ROW
  %dt = load NUMBER, ptr %step.at, align 8
  %size = fmul NUMBER %share, %dt
  call void @resize(ptr %Q, NUMBER %size, NUMBER zeroinitializer, NUMBER zeroinitializer)
  call void @whole(ptr %Q, ptr %T, i64 %stride, i64 1)
  call void @resize(ptr %Q, NUMBER %dt, NUMBER %share, NUMBER zeroinitializer)
  call void @take(ptr %S, ptr %Q, TRUTH %moved)
  br label %done
done:
  ret void
}

; keep(Q, S): Q becomes a copy of S.
define internal void @keep(ptr noalias %Q, ptr noalias %S) noinline {
entry:
  br label %row
row:
  %r = phi i64 [ 0, %entry ], [ %r.next, %row ]
  %at = mul i64 %r, CHUNK_STRIDE
  %here = getelementptr double, ptr %S, i64 %at
  %there = getelementptr double, ptr %Q, i64 %at
  %value = load CHUNK, ptr %here, align 8
  store CHUNK %value, ptr %there, align 8
  %r.next = add i64 %r, 1
  %more = icmp slt i64 %r.next, CHUNKS
  br i1 %more, label %row, label %done
done:
  ret void
}

; take(S, Q, which): lanes of S become those of Q where that is asked for.
define internal void @take(ptr noalias %S, ptr noalias %Q, TRUTH %which) noinline {
entry:
  %others = icmp eq TRUTH %which, zeroinitializer
  %some = call i1 @any(TRUTH %others)
  br i1 %some, label %row, label %all
all:
  call void @keep(ptr %S, ptr %Q)
  br label %done
row:
  %r = phi i64 [ 0, %entry ], [ %r.next, %row ]
  %at = mul i64 %r, WIDTH
  %here = getelementptr double, ptr %S, i64 %at
  %there = getelementptr double, ptr %Q, i64 %at
  %old = load volatile NUMBER, ptr %here, align 8
  %new = load NUMBER, ptr %there, align 8
  %value = select TRUTH %which, NUMBER %new, NUMBER %old
  store NUMBER %value, ptr %here, align 8
  %r.next = add i64 %r, 1
  %more = icmp slt i64 %r.next, ROWS
  br i1 %more, label %row, label %done
done:
  ret void
}

; polynomial(T, start, time): value, two derivatives and kinks of a table, as kernels/polynomial.py has them.
define internal ANSWER @polynomial(ptr %T, i64 %start, double %time) noinline {
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
  %kinks.index = add i64 %after.head, 1
  %kinks.at = getelementptr double, ptr %T, i64 %kinks.index
  %kinks.each = load double, ptr %kinks.at, align 8
  %after.period = add i64 %after.head, 2
  %turns = fdiv double %time, %period
  %turns.less = fsub double %turns, 0x3FE0000000000000
  %turns.big = fadd double %turns.less, 0x4338000000000000
  %turns.whole = fsub double %turns.big, 0x4338000000000000
  %kinks.past = fmul double %turns.whole, %kinks.each
  %past = fmul double %turns.whole, %period
  %folded = fsub double %time, %past
  br label %found
found:
  %pieces = phi i64 [ %number, %entry ], [ %positive, %fold ]
  %first = phi i64 [ %after.head, %entry ], [ %after.period, %fold ]
  %t = phi double [ %time, %entry ], [ %folded, %fold ]
  %kinks.before = phi double [ 0.0, %entry ], [ %kinks.past, %fold ]
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
  %result.0 = insertvalue ANSWER poison, double %value.next, 0
  %result.1 = insertvalue ANSWER %result.0, double %rate.next, 1
  %result.2 = insertvalue ANSWER %result.1, double %second, 2
  %eighths = mul i64 %pieces, 8
  %after.pieces = add i64 %first, %eighths
  %own = add i64 %after.pieces, %low
  %own.at = getelementptr double, ptr %T, i64 %own
  %own.value = load double, ptr %own.at, align 8
  %kinks = fadd double %kinks.before, %own.value
  %result.3 = insertvalue ANSWER %result.2, double %kinks, 3
  ret ANSWER %result.3
}
